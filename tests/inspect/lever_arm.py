#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether the sigma that `inspect` states for a lever arm is that of its errors: simulated car drives, each with other noise.

    lever_arm.py BINNACLE [--seeds N] [--first N] [--jobs N]

Receivers of five kinds take turns: white errors of velocity, errors correlated over 10 s, three times as large ones, fixes that are 0.1 s late, and
velocities that are means over 0.25 s. Asked of the squared errors over sigma, per axis: their mean is below the upper end of the band of 99.8 % of
a chi-square over the number of drives, widened by half, for each sigma is an estimate itself; forward and to the right it is above the lower end
too. Down, sigma counts with a receiver that is slower than most, and is larger than the errors. Exit status: 0, 1 it is not so.
"""

import argparse
import concurrent.futures
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

from simulated import FIX, FIX_UNITS, IMU, ROUTE, columns

SEGMENTS = [{"do": "still", "duration": "20 s"}] + ROUTE
AXES = ["forward", "right", "down"]
KINDS = ["white", "correlated", "poor", "late", "mean"]


def config(lever_arm):
    imu = columns(IMU, ["rad/s"] * 3 + ["m/s^2"] * 3)
    gnss = columns(FIX, FIX_UNITS)
    drive = {"type": "vehicle_simulator", "start": {"lat": "48.1 deg", "lon": "11.6 deg", "height": "520 m", "heading": "30 deg"},
             "segments": SEGMENTS, "repeat": 3, "roll_gradient": "4 deg/g", "pitch_gradient": "1.5 deg/g", "imu_rate": "100 Hz",
             "imu_kind": "rate", "ride": {"slip": 0.002, "heave": "0.03 m/s", "roll": "2 mrad", "pitch": "2 mrad"},
             "gyro": {"bias": "200 deg/h", "noise": "0.4 deg/sqrt(h)", "scale": "3000 ppm"},
             "accel": {"bias": "5 mg", "noise": "0.08 m/s/sqrt(h)", "scale": "3000 ppm"}, "gnss_rate": "20 Hz",
             "gnss": {"lever_arm": [f"{x} m" for x in lever_arm], "velocity_sigma": ["0.05 m/s", "0.05 m/s", "0.1 m/s"]}}
    return {"binnacle": 1, "sources": {"drive": drive}, "filters": {}, "sinks": {
        "imu": {"type": "csv_writer", "input": "drive.imu", "path": "imu.csv", "time": "t_s", "columns": imu},
        "gnss": {"type": "csv_writer", "input": "drive.gnss", "path": "gnss_clean.csv", "time": "t_s", "columns": gnss}}}


def spoil(folder, kind, noise):
    """The receiver of this kind: what its velocities have beyond white noise, and its labels."""
    lines = (folder / "gnss_clean.csv").read_text().splitlines()
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    step = math.exp(-1 / 10)
    error = [noise.gauss(0, 0.05) for _ in range(3)]
    with open(folder / "gnss.csv", "w") as file:
        file.write(lines[0] + "\n")
        for i in range(20, len(rows) - 20, 20):
            cells = list(rows[i])
            if kind == "late":
                cells[0] += 0.1
            if kind == "mean":
                cells[4:] = [sum(row[k] for row in rows[i - 2:i + 3]) / 5 + noise.gauss(0, 0.04) for k in (4, 5, 6)]
            if kind == "poor":
                cells[4:] = [v + noise.gauss(0, 0.15) for v in cells[4:]]
            if kind == "correlated":
                error = [step * e + math.sqrt(1 - step * step) * noise.gauss(0, 0.05) for e in error]
                cells[4:] = [v + e for v, e in zip(cells[4:], error)]
            file.write(",".join(f"{cell:.10f}" for cell in cells) + "\n")


def call(command, words, folder):
    done = subprocess.run([command] + words, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"binnacle {' '.join(words)}: {done.stderr}")
    return done.stdout


def one_drive(command, seed):
    noise = random.Random(seed)
    lever_arm = [round(noise.uniform(-2, 2), 3), round(noise.uniform(-1, 1), 3), round(noise.uniform(-2, 0), 3)]
    kind = KINDS[seed % 5]
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "drive.json").write_text(json.dumps(config(lever_arm)))
        call(command, ["run", "drive.json", "--seed", str(seed), "--quiet"], folder)
        spoil(folder, kind, noise)
        report = json.loads(call(command, ["inspect", "imu.csv", "gnss.csv", "--json"], folder))
    return seed, kind, lever_arm, report


def figures(report, axis):
    """Estimate and sigma [m]."""
    finding = next(each for each in report["findings"] if each["kind"] == "lever_arm" and each["field"] == axis)
    return finding["value"], finding["sigma"], finding["severity"]


def band(n):
    """Between which a chi-square of n over n is but for one in a thousand at each end (Wilson and Hilferty)."""
    return [(1 - 2 / (9 * n) + z * math.sqrt(2 / (9 * n))) ** 3 for z in (-3.09, 3.09)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    command = str(pathlib.Path(options.command).resolve())
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        drives = list(pool.map(lambda seed: one_drive(command, seed), range(options.first, options.first + options.seeds)))
    low, high = band(options.seeds)
    high *= 1.5
    is_right = True
    for k, axis in enumerate(AXES):
        squares = []
        for seed, kind, lever_arm, report in drives:
            value, sigma, severity = figures(report, axis)
            squares.append(((value - lever_arm[k]) / sigma) ** 2)
            print(f"{axis:8s} {seed:3d} {kind:10s} true {lever_arm[k]:7.3f} m, found {value:7.3f} +- {sigma:.3f} m ({severity}), "
                  f"{(value - lever_arm[k]) / sigma:6.2f} sigma")
        mean = sum(squares) / len(squares)
        holds = (low if axis != "down" else 0) < mean < high
        is_right &= holds
        print(f"{'ok  ' if holds else 'FAIL'} {axis}: mean square of error over sigma {mean:.2f} of {len(squares)} drives, "
              f"band {low:.2f} to {high:.2f}")
    return 0 if is_right else 1


if __name__ == "__main__":
    sys.exit(main())
