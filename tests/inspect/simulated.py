# SPDX-License-Identifier: Apache-2.0
"""The route of the simulated drives, and the columns of their files."""

ROUTE = [
    {"do": "accelerate", "to": "12 m/s", "acceleration": "1.5 m/s^2"}, {"do": "turn", "angle": "90 deg", "rate": "15 deg/s"},
    {"do": "straight", "duration": "15 s"}, {"do": "turn", "angle": "-120 deg", "rate": "-12 deg/s"},
    {"do": "climb", "height": "6 m", "duration": "20 s"}, {"do": "accelerate", "to": "6 m/s", "acceleration": "-1.5 m/s^2"},
    {"do": "turn", "angle": "170 deg", "rate": "25 deg/s"}, {"do": "accelerate", "to": "18 m/s", "acceleration": "1.2 m/s^2"},
    {"do": "straight", "duration": "10 s"}, {"do": "turn", "angle": "60 deg", "rate": "6 deg/s"},
    {"do": "accelerate", "to": 0, "acceleration": "-2 m/s^2"}]
IMU = ["wx", "wy", "wz", "fx", "fy", "fz"]
FIX = ["lat", "lon", "height", "vn", "ve", "vd"]
FIX_UNITS = ["deg", "deg", "m"] + ["m/s"] * 3


def columns(fields, units):
    return {field: {"column": field, "unit": unit} for field, unit in zip(fields, units)}
