# SPDX-License-Identifier: Apache-2.0
"""Faults that people have in their data, each planted into a recorded drive, with what `inspect` reports of it.

A fault changes text cells of imu.csv and gnss.csv of a drive and leaves the headers, which then are wrong where units differ.
"""

import math
import random

W, F = ["wx", "wy", "wz"], ["fx", "fy", "fz"]
COLUMN = {"wx": 1, "wy": 2, "wz": 3, "fx": 4, "fy": 5, "fz": 6, "lat": 1, "lon": 2, "height": 3, "vn": 4, "ve": 5,
          "vd": 6, "position_sd_n": 7, "position_sd_e": 8, "position_sd_d": 9, "velocity_sd_n": 10,
          "velocity_sd_e": 11, "velocity_sd_d": 12, "yaw": 13}
NAME = {1: "gx_radps", 2: "gy_radps", 3: "gz_radps", 4: "ax_mps2", 5: "ay_mps2", 6: "az_mps2"}
G = 9.80665
DEG = math.pi / 180


class Drive:
    """Rows of cells; `imu` and `gnss` are lists of lists of text, without headers."""

    def __init__(self, name, imu, gnss, yaw):
        self.name, self.imu, self.gnss, self.yaw = name, imu, gnss, yaw
        self.step = (float(imu[-1][0]) - float(imu[0][0])) / (len(imu) - 1)
        # A time in the second half from which the vehicle moves for 20 s: faults of a part of the drive begin here.
        t = [float(row[0]) for row in gnss]
        speed = [math.hypot(float(row[4]), float(row[5])) for row in gnss]
        self.row = next(i for i in range(len(gnss) // 2, len(gnss) - 50)
                        if all(s > 2 for s in speed[i:i + 40]) and t[i + 40] - t[i] < 25)
        self.begin = t[self.row]
        self.imu_row = next(i for i, row in enumerate(imu) if float(row[0]) >= self.begin)

    def copy(self):
        other = object.__new__(Drive)
        other.__dict__.update(self.__dict__)
        other.imu, other.gnss = [list(row) for row in self.imu], [list(row) for row in self.gnss]
        return other


def each(rows, fields, change):
    for row in rows:
        for field in fields:
            row[COLUMN[field]] = repr(change(float(row[COLUMN[field]])))


def times(of, fields, factor):
    def plant(drive):
        each(getattr(drive, of), fields, lambda x: x * factor)
    return plant


def per_sample(fields):
    def plant(drive):
        each(drive.imu, fields, lambda x: x * drive.step)
    return plant


def exchange(of, pairs):
    def plant(drive):
        for row in getattr(drive, of):
            for a, b in pairs:
                row[COLUMN[a]], row[COLUMN[b]] = row[COLUMN[b]], row[COLUMN[a]]
    return plant


def cycle(fields):
    """The column of the first holds the second's numbers, and so on."""
    def plant(drive):
        for row in drive.imu:
            values = [row[COLUMN[field]] for field in fields]
            for field, value in zip(fields, values[1:] + values[:1]):
                row[COLUMN[field]] = value
    return plant


def labels(of, change):
    def plant(drive):
        for row in getattr(drive, of):
            row[0] = repr(change(float(row[0])))
    return plant


def jitter(drive):
    rng = random.Random(1)
    for row in drive.imu:
        row[0] = repr(float(row[0]) + drive.step * rng.uniform(-0.45, 0.45))


def block_again(drive):
    i = drive.imu_row
    drive.imu[i:i] = [list(row) for row in drive.imu[i - 100:i]]


def twice(of):
    def plant(drive):
        rows = getattr(drive, of)
        for i in range(20):
            at = len(rows) // 3 + 7 * i
            rows.insert(at, list(rows[at]))
    return plant


def hole(of, seconds):
    def plant(drive):
        rows = getattr(drive, of)
        rows[:] = [row for row in rows if not drive.begin < float(row[0]) < drive.begin + seconds]
    return plant


def cells(of, fields, text, count):
    def plant(drive):
        rows = getattr(drive, of)
        for row in rows[len(rows) // 2:len(rows) // 2 + count]:
            for field in fields:
                row[COLUMN[field]] = text
    return plant


def held(of, fields, seconds):
    def plant(drive):
        kept = None
        for row in getattr(drive, of):
            if seconds and not drive.begin <= float(row[0]) < drive.begin + seconds:
                continue
            kept = kept or list(row)
            for field in fields:
                row[COLUMN[field]] = kept[COLUMN[field]]
    return plant


def clipped(field, share):
    def plant(drive):
        limit = limit_of(drive, field, share)
        each(drive.imu, [field], lambda x: max(-limit, min(limit, x)))
    return plant


def limit_of(drive, field, share):
    size = sorted(abs(float(row[COLUMN[field]])) for row in drive.imu)
    return round(size[int(share * len(size))], 3)


def rounded(field, step):
    def plant(drive):
        each(drive.imu, [field], lambda x: step * round(x / step))
    return plant


def added(of, fields, by, from_here=False, one_row=False):
    def plant(drive):
        rows = getattr(drive, of)
        begin = drive.row if of == "gnss" else drive.imu_row
        rows = rows[begin:begin + 1] if one_row else rows[begin:] if from_here else rows
        each(rows, fields, lambda x: x + by)
    return plant


def noisy_velocity(drive):
    rng = random.Random(2)
    for row in drive.gnss:
        if drive.begin <= float(row[0]) < drive.begin + 20:
            for field in ("vn", "ve", "vd"):
                row[COLUMN[field]] = repr(float(row[COLUMN[field]]) + rng.gauss(0, 2))


def cut(drive):
    for i in range(5):
        drive.imu[1000 + 500 * i] = drive.imu[1000 + 500 * i][:4]


def antenna(forward):
    """Fixes of an antenna that is so far further ahead [m], with the reference's yaw."""
    def plant(drive):
        for row in drive.gnss:
            t = float(row[0])
            yaw, before, after = drive.yaw(t), drive.yaw(t - 0.1), drive.yaw(t + 0.1)
            rate = math.remainder(after - before, 2 * math.pi) / 0.2
            north, east = forward * math.cos(yaw), forward * math.sin(yaw)
            lat = float(row[1])
            row[1] = repr(lat + north / 6.37e6 / DEG)
            row[2] = repr(float(row[2]) + east / (6.39e6 * math.cos(lat * DEG)) / DEG)
            row[4] = repr(float(row[4]) - rate * east)
            row[5] = repr(float(row[5]) + rate * north)
    return plant


def columns(channel, of):
    return {"sources": {channel: {"columns": of}}}


def unit(channel, fields, **what):
    return columns(channel, {field: what for field in fields})


class Fault:
    """kinds: any of them; fields: as a set; value: number or function of the drive, within `within` of it (share of it, or absolute where
    `absolute`). remedies: which changes of the config are right; none: a warning may propose nothing."""

    def __init__(self, name, plant, kind, channel, fields, value=None, within=0.02, absolute=False, remedies=(),
                 severity="warning", shift=False, also=()):
        self.name, self.plant, self.channel, self.fields = name, plant, channel, set(fields)
        self.kinds = kind.split("|")
        self.value, self.within, self.absolute, self.shift = value, within, absolute, shift
        self.remedies, self.severity, self.also = list(remedies), severity, also


SKIP = [{"sources": {"imu": {"invalid_rows": "skip"}}}]
SKIP_FIX = [{"sources": {"gnss": {"invalid_rows": "skip"}}}]
BOTH = "imu, gnss"


def inverted(fields):
    return columns("imu", {field: {"scale": -1} for field in fields})


def from_column(**of):
    return columns("imu", {field: {"column": NAME[COLUMN[source]]} for field, source in of.items()})


def late(name, of, seconds):
    offset = seconds if of == "gnss" else -seconds
    return Fault(name, labels(of, lambda t: t + seconds), "delay", BOTH, [], offset, 0.04, True,
                 remedies=[("offset", -offset, 0.06)], shift=True)


FAULTS = [
    # units of the inertial sensor
    Fault("rates in deg/s", times("imu", W, 1 / DEG), "rate_unit", "imu", W, DEG,
          remedies=[unit("imu", W, unit="deg/s", kind="rate")]),
    Fault("rates in mdeg/s", times("imu", W, 1e3 / DEG), "rate_unit", "imu", W, DEG * 1e-3,
          remedies=[unit("imu", W, unit="mdeg/s", kind="rate"), unit("imu", W, unit="deg/s", kind="rate", scale=1e-3)]),
    Fault("rates are increments", per_sample(W), "rate_unit", "imu", W, lambda drive: 1 / drive.step,
          remedies=[unit("imu", W, unit="rad", kind="increment")]),
    Fault("force in g", times("imu", F, 1 / G), "force_unit", "imu", F, G,
          remedies=[unit("imu", F, unit="g", kind="rate")]),
    Fault("force in mg", times("imu", F, 1e3 / G), "force_unit", "imu", F, G * 1e-3,
          remedies=[unit("imu", F, unit="mg", kind="rate"), unit("imu", F, unit="g", kind="rate", scale=1e-3)]),
    Fault("force is increments", per_sample(F), "force_unit", "imu", F, lambda drive: 1 / drive.step,
          remedies=[unit("imu", F, unit="m/s", kind="increment")]),
    # signs and axes
    Fault("sign of force (gravity)", times("imu", F, -1), "force_sign|force_axes", "imu", F, -1, remedies=[inverted(F)]),
    Fault("sign of rates", times("imu", W, -1), "rate_sign|rate_axes", "imu", W, -1, remedies=[inverted(W)]),
    Fault("wx inverted", times("imu", ["wx"], -1), "rate_axes", "imu", ["wx"], -1, remedies=[inverted(["wx"])]),
    Fault("wy inverted", times("imu", ["wy"], -1), "rate_axes", "imu", ["wy"], -1, remedies=[inverted(["wy"])]),
    Fault("wz inverted", times("imu", ["wz"], -1), "rate_axes", "imu", ["wz"], -1, remedies=[inverted(["wz"])]),
    Fault("fx inverted", times("imu", ["fx"], -1), "force_axes", "imu", ["fx"], -1, remedies=[inverted(["fx"])]),
    Fault("fy inverted", times("imu", ["fy"], -1), "force_axes", "imu", ["fy"], -1, remedies=[inverted(["fy"])]),
    Fault("fz inverted", times("imu", ["fz"], -1), "force_axes", "imu", ["fz"], -1, remedies=[inverted(["fz"])]),
    Fault("wx and wy exchanged", exchange("imu", [("wx", "wy")]), "rate_axes", "imu", ["wx", "wy"], -1,
          remedies=[from_column(wx="wy", wy="wx")]),
    Fault("wy and wz exchanged", exchange("imu", [("wy", "wz")]), "rate_axes", "imu", ["wy", "wz"], -1,
          remedies=[from_column(wy="wz", wz="wy")]),
    Fault("wx and wz exchanged", exchange("imu", [("wx", "wz")]), "rate_axes", "imu", ["wx", "wz"], -1,
          remedies=[from_column(wx="wz", wz="wx")]),
    Fault("fx and fy exchanged", exchange("imu", [("fx", "fy")]), "force_axes", "imu", ["fx", "fy"], -1,
          remedies=[from_column(fx="fy", fy="fx")]),
    Fault("fy and fz exchanged", exchange("imu", [("fy", "fz")]), "force_axes", "imu", ["fy", "fz"], -1,
          remedies=[from_column(fy="fz", fz="fy")]),
    Fault("rates in cyclic order", cycle(W), "rate_axes", "imu", W, 1,
          remedies=[from_column(wx="wz", wy="wx", wz="wy"), from_column(fx="fy", fy="fz", fz="fx")]),
    Fault("left-handed: y of both inverted", times("imu", ["wy", "fy"], -1), "mirrored", "imu", ["fx", "fy", "wx", "wy"], -1,
          remedies=["mirror"]),
    Fault("left-handed: x and y of both exchanged", exchange("imu", [("wx", "wy"), ("fx", "fy")]), "mirrored", "imu",
          ["fx", "fy", "wx", "wy"], -1, remedies=["mirror"]),
    # clocks and labels
    late("GNSS clock 18 s back (UTC for GPS)", "gnss", -18.0),
    late("GNSS 0.2 s late", "gnss", 0.2),
    late("GNSS 0.5 s late", "gnss", 0.5),
    late("GNSS 1 s late", "gnss", 1.0),
    late("IMU 0.2 s late", "imu", 0.2),
    late("IMU 0.5 s late", "imu", 0.5),
    late("IMU 1 s late", "imu", 1.0),
    late("IMU on Unix time", "imu", 1.7e9),
    Fault("IMU labels in ms", labels("imu", lambda t: t * 1e3), "time_unit", "imu", [], 1e-3,
          remedies=[{"sources": {"imu": {"time": {"unit": "ms"}}}}]),
    Fault("GNSS labels in ms", labels("gnss", lambda t: t * 1e3), "time_unit", "gnss", [], 1e-3,
          remedies=[{"sources": {"gnss": {"time": {"unit": "ms"}}}}]),
    Fault("IMU time goes back 1 s", block_again, "time_back", "imu", [], -1, 0.05, remedies=SKIP),
    Fault("IMU rows twice", twice("imu"), "duplicate", "imu", [], 20, 0, remedies=SKIP),
    Fault("GNSS rows twice", twice("gnss"), "duplicate", "gnss", [], 20, 0, remedies=SKIP_FIX),
    Fault("IMU gap of 5 s", hole("imu", 5), "gap", "imu", [], 5, 0.02),
    Fault("GNSS gap of 20 s", hole("gnss", 20), "gap", "gnss", [], 20, 0.06),
    Fault("IMU labels scatter", jitter, "jitter", "imu", [], lambda drive: 0.9 / math.sqrt(12) * drive.step, 0.3,
          remedies=["interval"], also=("time_back",)),
    Fault("rows cut", cut, "cut_row", "imu", [], 5, 0, remedies=SKIP),
    # fields
    Fault("wz is nan", cells("imu", ["wz"], "nan", 50), "nan", "imu", ["wz"], 50, 0,
          remedies=SKIP + [unit("imu", ["wz"], missing=["nan", ""])]),
    Fault("wy is spoilt", cells("imu", ["wy"], "1.2.3", 20), "nan", "imu", ["wy"], 20, 0, remedies=SKIP),
    Fault("vn is empty", cells("gnss", ["vn"], "", 30), "nan", "gnss", ["vn"], 30, 0,
          remedies=SKIP_FIX + [unit("gnss", ["vn"], missing=["nan", ""])]),
    Fault("fy constant", held("imu", ["fy"], 0), "constant", "imu", ["fy"],
          lambda drive: float(drive.imu[0][COLUMN["fy"]])),
    Fault("wy stuck for 20 s", held("imu", ["wy"], 20), "stuck", "imu", ["wy"],
          lambda drive: float(drive.imu[drive.imu_row][COLUMN["wy"]])),
    Fault("fx clipped", clipped("fx", 0.995), "clipped", "imu", ["fx"], lambda drive: limit_of(drive, "fx", 0.995), "size"),
    Fault("wz clipped", clipped("wz", 0.995), "clipped", "imu", ["wz"], lambda drive: limit_of(drive, "wz", 0.995), "size"),
    Fault("fy in steps of 1 m/s^2", rounded("fy", 1.0), "quantized", "imu", ["fy"], 1),
    Fault("wx in steps of 1 deg/s", rounded("wx", DEG), "quantized", "imu", ["wx"], DEG),
    Fault("a spike of fz", added("imu", ["fz"], 200, one_row=True), "spike", "imu", ["fz"], 200, 0.05),
    # fixes
    Fault("deviation zero", cells("gnss", ["position_sd_n"], "0", 30), "zero_deviation", "gnss", ["position_sd_n"], 30, 0,
          remedies=[unit("gnss", ["position_sd_n"], missing=["0"])]),
    Fault("deviation of position in um", times("gnss", ["position_sd_n"], 1e6), "deviation", "gnss", ["position_sd_n"]),
    Fault("deviation of velocity in km/s", times("gnss", ["velocity_sd_e"], 1e-3), "deviation", "gnss", ["velocity_sd_e"]),
    Fault("lat and lon exchanged", exchange("gnss", [("lat", "lon")]), "position_exchanged", "gnss", ["lat", "lon"],
          remedies=[columns("gnss", {"lat": {"column": "lon_deg"}, "lon": {"column": "lat_deg"}})]),
    Fault("lat and lon in rad", times("gnss", ["lat", "lon"], DEG), "position_unit", "gnss", ["lat", "lon"], 1 / DEG, 0.03,
          remedies=[unit("gnss", ["lat", "lon"], unit="rad")]),
    Fault("lat and lon in 1e-7 deg", times("gnss", ["lat", "lon"], 1e7), "position_unit", "gnss", ["lat", "lon"], 1e-7,
          0.03, remedies=[unit("gnss", ["lat", "lon"], unit="deg", scale=1e-7), unit("gnss", ["lat", "lon"], scale=1e-7)]),
    Fault("sign of lon", times("gnss", ["lon"], -1), "position_sign", "gnss", ["lon"],
          remedies=[unit("gnss", ["lon"], scale=-1)]),
    Fault("sign of height", times("gnss", ["height"], -1), "height_sign|vertical_sign", "gnss", ["height"],
          remedies=[unit("gnss", ["height"], scale=-1)]),
    Fault("height in mm", times("gnss", ["height"], 1e3), "height_unit", "gnss", ["height"], 1e-3, 0.15,
          remedies=[unit("gnss", ["height"], unit="mm")]),
    Fault("vd points up", times("gnss", ["vd"], -1), "down_sign|vertical_sign", "gnss", ["vd"],
          remedies=[unit("gnss", ["vd"], scale=-1)]),
    Fault("vn and ve exchanged (ENU)", exchange("gnss", [("vn", "ve")]), "velocity_exchanged", "gnss", ["vn", "ve"],
          remedies=[columns("gnss", {"vn": {"column": "ve_mps"}, "ve": {"column": "vn_mps"}})]),
    Fault("sign of ve", times("gnss", ["ve"], -1), "velocity_sign", "gnss", ["ve"],
          remedies=[unit("gnss", ["ve"], scale=-1)]),
    Fault("velocity in km/h", times("gnss", ["vn", "ve", "vd"], 3.6), "velocity_unit", "gnss", ["vn", "ve", "vd"], 1 / 3.6,
          0.03, remedies=[unit("gnss", ["vn", "ve", "vd"], unit="km/h")]),
    Fault("velocity in knots", times("gnss", ["vn", "ve", "vd"], 1 / 0.514444), "velocity_unit", "gnss", ["vn", "ve", "vd"],
          0.514444, 0.03, remedies=[unit("gnss", ["vn", "ve", "vd"], unit="kn")]),
    Fault("velocity in mm/s", times("gnss", ["vn", "ve", "vd"], 1e3), "velocity_unit", "gnss", ["vn", "ve", "vd"], 1e-3, 0.03,
          remedies=[unit("gnss", ["vn", "ve", "vd"], unit="mm/s")]),
    Fault("velocity held for 15 s", held("gnss", ["vn", "ve", "vd"], 15), "velocity_held", "gnss", ["vn", "ve", "vd"], 15, 0.1,
          also=("velocity_fault",)),
    Fault("velocity faulty for 20 s", noisy_velocity, "velocity_fault", "gnss", ["vn", "ve", "vd"], None,
          also=("spike", "velocity_jump")),
    Fault("position held for 15 s", held("gnss", ["lat", "lon"], 15), "position_held", "gnss", ["lat", "lon"], 15, 0.1,
          also=("position_jump", "spike")),
    Fault("position jumps 50 m", added("gnss", ["lat"], 50 / 6.37e6 / DEG, from_here=True), "position_jump", "gnss",
          ["lat", "lon"], 50, 0.05),
    Fault("yaw in deg", times("gnss", ["yaw"], 1 / DEG), "heading_unit", "gnss", ["yaw"], DEG,
          remedies=[unit("gnss", ["yaw"], unit="deg")]),
    Fault("yaw turns the other way (from east)", lambda drive: each(drive.gnss, ["yaw"], lambda x: math.pi / 2 - x),
          "heading_sense", "gnss", ["yaw"], remedies=["heading"]),
    Fault("yaw 90 deg off", added("gnss", ["yaw"], math.pi / 2), "heading_offset", "gnss", ["yaw"], 90, 0.02,
          remedies=["heading"]),
    Fault("antenna 4 m further ahead", antenna(4), "lever_arm", BOTH, ["forward"], 4, 1, True, severity="finding", shift=True),
    Fault("antenna 4 m further behind (sign)", antenna(-4), "lever_arm", BOTH, ["forward"], -4, 1, True, severity="finding",
          shift=True),
]
