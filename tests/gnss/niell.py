#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Slant delays of the troposphere by Niell's mapping functions, written from the paper for tests/gnss.

A. E. Niell, J. Geophys. Res. 101 (B2) (1996) 3227-3246. Nothing is shared with the plugin: other forms of the same formulas,
angles in degrees, numpy-free. Prints: latitude, height, day (-1: the mean of the year), elevation, hydrostatic and wet factor, slant and zenith delay.
"""
import bisect
import math

LATITUDES = [15, 30, 45, 60, 75]
HYDROSTATIC = {
    "a": ([1.2769934, 1.2683230, 1.2465397, 1.2196049, 1.2045996], [0.0, 1.2709626, 2.6523662, 3.4000452, 4.1202191]),
    "b": ([2.9153695, 2.9152299, 2.9288445, 2.9022565, 2.9024912], [0.0, 2.1414979, 3.0160779, 7.2562722, 11.723375]),
    "c": ([62.610505, 62.837393, 63.721774, 63.824265, 64.258455], [0.0, 9.0128400, 4.3497037, 84.795348, 170.37206]),
}  # mean in 1e-3, amplitude in 1e-5
WET = {
    "a": [5.8021897e-4, 5.6794847e-4, 5.8118019e-4, 5.9727542e-4, 6.1641693e-4],
    "b": [1.4275268e-3, 1.5138625e-3, 1.4572752e-3, 1.5007428e-3, 1.7599082e-3],
    "c": [4.3472961e-2, 4.6729510e-2, 4.3908931e-2, 4.4626982e-2, 5.4736038e-2],
}


def interpolated(values, lat):
    lat = abs(lat)
    if lat <= 15:
        return values[0]
    if lat >= 75:
        return values[-1]
    k = bisect.bisect_right(LATITUDES, lat)
    x0, x1 = LATITUDES[k - 1], LATITUDES[k]
    return values[k - 1] + (values[k] - values[k - 1]) * (lat - x0) / (x1 - x0)


def marini(el, a, b, c):
    s = math.sin(math.radians(el))
    return (1 + a / (1 + b / (1 + c))) / (s + a / (s + b / (s + c)))


def hydrostatic(lat, height, day, el):
    if day is None:
        season = 0.0
    else:
        season = math.cos(2 * math.pi * (day - 28 + (365.25 / 2 if lat < 0 else 0)) / 365.25)
    a, b, c = (1e-3 * interpolated(mean, lat) - 1e-5 * interpolated(amplitude, lat) * season
               for mean, amplitude in HYDROSTATIC.values())
    correction = 1 / math.sin(math.radians(el)) - marini(el, 2.53e-5, 5.49e-3, 1.14e-3)
    return marini(el, a, b, c) + correction * height / 1000


def wet(lat, el):
    return marini(el, *(interpolated(row, lat) for row in WET.values()))


def zenith(lat, height):
    pressure = 1013.25 * (1 - 2.2557e-5 * height) ** 5.2568
    kelvin = 15.0 - 6.5e-3 * height + 273.16
    vapour = 0.7 * 6.108 * math.exp((17.15 * kelvin - 4684.0) / (kelvin - 38.45))
    dry = 0.0022768 * pressure / (1 - 0.00266 * math.cos(math.radians(2 * lat)) - 0.00028 * height / 1e3)
    return dry, 0.002277 * (1255.0 / kelvin + 0.05) * vapour


for lat in (-80, -52.5, -30, 0, 10, 22, 35.16, 45, 68, 90):
    for height in (-100, 0, 68.4, 1500):
        for day in (None, 1, 28, 92, 210.5):
            for el in (5, 10, 15, 30, 90):
                dry, moist = zenith(lat, height)
                m_h, m_w = hydrostatic(lat, height, day, el), wet(lat, el)
                slant = dry * m_h + moist * m_w
                print(lat, height, day or -1, el, *(f"{v:.14g}" for v in (m_h, m_w, slant, dry + moist)))
