#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes site.obs and site.nav, RINEX 3.04, of BeiDou (C) and GPS (G) into a folder, for a receiver that stands still.

Written from BDS-SIS-ICD-B1I-3.0 tables 5-10, 5-11 and IS-GPS-200 table 20-IV by itself, in other forms than the plugin: orbits are
built of vectors in inertial axes that agree with the earth's at the time of the message, and a pseudorange is the light's way
there.
No noise, no atmosphere. Prints a line per satellite: name, position and velocity at the first epoch in ECEF, clock with relativity.
"""
import math
import pathlib
import sys

C = 299792458.0
PLACE = (-3962108.673, 3381309.574, 3668678.638)
WEEK, DAY, HOUR, MINUTE = 2183, 2, 3, 30  # of GPS time: 2021-11-09 03:30
EPOCHS = 20
CLOCK, DRIFT, BEIDOU_MORE = 2.5e-4, 1e-9, 20.0  # s, s/s, m
SYSTEMS = {"G": (3.986005e14, 7.2921151467e-5, 1575.42e6, 0.0), "C": (3.986004418e14, 7.2921150e-5, 1561.098e6, 14.0)}


def satellites():
    """name, sqrt(A), e, i0, omega0 (of the week's begin), perigee, M0, other terms."""
    made = []

    def add(name, root, e, inclination, node_lon, perigee, along, k):
        # node_lon: longitude of the node at toe; along: argument of latitude at toe.
        toe = 2 * 86400 + 14400 - (1800 if name[0] == "C" else 0)
        omega = SYSTEMS[name[0]][1]
        tilted = name[0] == "C" and (int(name[1:]) <= 5 or int(name[1:]) >= 59)
        node = math.radians(node_lon) + omega * toe
        sign = 1 if k % 2 else -1
        made.append(dict(name=name, root=root, e=e, i0=math.radians(inclination), omega0=node, perigee=perigee,
                         m0=math.radians(along) - perigee, toe=toe, tilted=tilted, delta_n=4.1e-9 + 1e-11 * k,
                         omega_dot=-7.6e-9 - 1e-11 * k, i_dot=sign * 3e-10, cuc=sign * 2e-6, cus=7e-6, crc=180.0 + k,
                         crs=sign * 70.0, cic=sign * 6e-8, cis=-8e-8, af0=sign * 1e-5 * (k + 1), af1=sign * 2e-11, af2=0.0,
                         tgd=sign * 5e-9, tgd2=9e-9))

    geo = math.sqrt(42164200.0)
    for k, (name, along) in enumerate([("C01", 140.0), ("C03", 110.5), ("C59", 80.0)]):
        add(name, geo, 0.0004, 5.2 + 0.3 * k, 3.0 * k, 0.4, along - 3.0 * k, k)
    for k, (name, node) in enumerate([("C06", 118.0), ("C09", 95.0), ("C38", 112.0)]):
        add(name, geo, 0.006, 55.0, node, -2.5, 30.0 + 25 * k, 3 + k)
    meo = [("C19", 60.0, 50.0), ("C23", 100.0, 70.0), ("C27", 150.0, 100.0), ("C35", 120.0, 10.0), ("C46", 180.0, 130.0)]
    for k, (name, node, along) in enumerate(meo):
        add(name, 5282.6, 0.0008, 55.3, node, 0.7, along, 6 + k)
    gps = [("G02", 60.0, 60.0), ("G05", 110.0, 35.0), ("G12", 150.0, 80.0), ("G17", 100.0, 80.0), ("G21", 170.0, 135.0),
           ("G30", 125.0, 5.0)]
    for k, (name, node, along) in enumerate(gps):
        add(name, 5153.7, 0.009, 55.0, node, 1.1, along, 11 + k)
    return made


def rotated(v, angle, axis):
    """Right-handed turn of a vector."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = v
    return (x, c * y - s * z, s * y + c * z) if axis == 0 else (c * x - s * y, s * x + c * y, z)


def orbit(s, t):
    """ECEF at system time t (s of the system's week), and the clock's offset."""
    mu, omega, _, _ = SYSTEMS[s["name"][0]]
    a = s["root"] ** 2
    tk = t - s["toe"]
    mean = s["m0"] + (math.sqrt(mu / a ** 3) + s["delta_n"]) * tk
    E = mean
    for _ in range(60):
        E = mean + s["e"] * math.sin(E)
    true = 2 * math.atan2(math.sqrt(1 + s["e"]) * math.sin(E / 2), math.sqrt(1 - s["e"]) * math.cos(E / 2))
    arg = true + s["perigee"]
    c2, s2 = math.cos(2 * arg), math.sin(2 * arg)
    u = arg + s["cuc"] * c2 + s["cus"] * s2
    r = a * (1 - s["e"] * math.cos(E)) + s["crc"] * c2 + s["crs"] * s2
    i = s["i0"] + s["i_dot"] * tk + s["cic"] * c2 + s["cis"] * s2
    plane = (r * math.cos(u), r * math.sin(u), 0.0)
    node = s["omega0"] + s["omega_dot"] * tk - omega * s["toe"]  # in inertial axes: those of the earth at toe
    inertial = rotated(rotated(plane, i, 0), node, 2)
    if s["tilted"]:
        inertial = rotated(inertial, math.radians(5), 0)
    ecef = rotated(inertial, -omega * tk, 2)
    dt = t - s["toe"]  # toc is toe
    clock = s["af0"] + s["af1"] * dt + s["af2"] * dt * dt - 2 * math.sqrt(mu) / C ** 2 * s["e"] * s["root"] * math.sin(E)
    return ecef, clock


def difference(a, b):
    return tuple(x - y for x, y in zip(a, b))


def norm(v):
    return math.sqrt(sum(x * x for x in v))


def pseudorange(s, label, receiver_clock):
    """label: of the receiver's clock, GPS seconds of week."""
    _, _, _, behind = SYSTEMS[s["name"][0]]
    received = label - receiver_clock
    travel = 0.1
    for _ in range(20):
        there, clock = orbit(s, received - travel - behind)
        here = rotated(PLACE, SYSTEMS["G"][1] * travel, 2)  # in the axes of transmission
        travel = norm(difference(there, here)) / C
    there, clock = orbit(s, received - travel - behind)
    more = BEIDOU_MORE if s["name"][0] == "C" else 0.0
    return C * (travel + receiver_clock - clock + s["tgd"]) + more, there


def up(r):
    return sum(x * y for x, y in zip(difference(r, PLACE), PLACE)) / norm(difference(r, PLACE)) / norm(PLACE)


def line(content, label):
    return f"{content:<60}{label}\n"


def number(value):
    return f"{value:19.12E}".replace("E", "D")


def stamp(seconds):
    second = round(seconds) % 86400
    return f"2021 11 {7 + round(seconds) // 86400:02d} {second // 3600:02d} {second // 60 % 60:02d} {second % 60:02d}"


def message(s):
    week = WEEK - (1356 if s["name"][0] == "C" else 0)
    rows = [(1.0, s["crs"], s["delta_n"], s["m0"]), (s["cuc"], s["e"], s["cus"], s["root"]),
            (s["toe"], s["cic"], s["omega0"], s["cis"]), (s["i0"], s["crc"], s["perigee"], s["omega_dot"]),
            (s["i_dot"], 0, week, 0), (2.0, 0, s["tgd"], s["tgd2"] if s["name"][0] == "C" else 1), (s["toe"] - 3600, 0, 0, 0)]
    text = f"{s['name']} {stamp(s['toe'])}" + "".join(map(number, (s["af0"], s["af1"], s["af2"]))) + "\n"
    return text + "".join("    " + "".join(map(number, row)) + "\n" for row in rows)


def as_written(s):
    """What the twelve digits of a file leave of it."""
    return {key: float(f"{v:.12e}") if isinstance(v, float) else v for key, v in s.items()}


def main(folder):
    sky = [as_written(s) for s in satellites()]
    first = DAY * 86400 + HOUR * 3600 + MINUTE * 60
    nav = line("     3.04           N: GNSS NAV DATA    M: Mixed", "RINEX VERSION / TYPE") + line("", "END OF HEADER")
    nav += "".join(message(s) for s in sky)
    obs = (line("     3.04           OBSERVATION DATA    M: Mixed", "RINEX VERSION / TYPE") +
           line("site", "MARKER NAME") +
           line("".join(f"{x:14.4f}" for x in PLACE), "APPROX POSITION XYZ") +
           line("G    3 C1C D1C S1C", "SYS / # / OBS TYPES") + line("C    3 C2I D2I S2I", "SYS / # / OBS TYPES") +
           line("  2021    11     9     3    30    0.0000000     GPS", "TIME OF FIRST OBS") + line("", "END OF HEADER"))
    for k in range(EPOCHS):
        t = first + k
        receiver = CLOCK + DRIFT * k
        rows = []
        for s in sky:
            value, there = pseudorange(s, t, receiver)
            if up(there) < 0.1:
                continue
            frequency = SYSTEMS[s["name"][0]][2]
            later, earlier = (pseudorange(s, t + d, receiver + DRIFT * d)[0] for d in (0.5, -0.5))
            rows.append(f"{s['name']}{value:14.3f}  {-(later - earlier) * frequency / C:14.3f}  {45.0:14.3f}  \n")
        obs += f"> {stamp(t)}.0000000  0{len(rows):3d}\n" + "".join(rows)
    pathlib.Path(folder, "site.nav").write_text(nav)
    pathlib.Path(folder, "site.obs").write_text(obs)
    for s in sky:
        t = first - SYSTEMS[s["name"][0]][3]
        here, clock = orbit(s, t)
        velocity = difference(orbit(s, t + 0.5)[0], orbit(s, t - 0.5)[0])
        print(s["name"], *(f"{x:.6f}" for x in here + velocity), f"{clock:.17g}", f"{up(here):.3f}")


main(sys.argv[1])
