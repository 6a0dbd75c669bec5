#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `inspect --write` proposes for simulated drives, run as it is, against their truth.

    proposed.py BINNACLE [--seed N] [--keep DIR]

Four drives with other axes, rates, units and receivers; one of them begins without rest. Asked of each: no warning, the verdict `ok`, less than 2 % of the
fixes are refused, and the errors stay within the bounds below. Exit status: 0, 1 it is not so.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

from simulated import FIX, FIX_UNITS, IMU, ROUTE, columns

SD = ["position_sd_n", "position_sd_e", "position_sd_d", "velocity_sd_n", "velocity_sd_e", "velocity_sd_d"]

# rest [s]; turn of the sensor; IMU rate, units of rates and forces; GNSS rate, whether it states deviations; its lever arm.
DRIVES = {
    "level sensor, 40 s of rest": (40, {}, "100 Hz", "deg/s", "g", "1 Hz", False, [1.2, 0.3, -1.0]),
    "sensor to the left and up, 20 s of rest": (20, {"yaw": "90 deg", "flip": "flu_to_frd"}, "50 Hz", "rad/s", "m/s^2", "5 Hz", True,
                                                [-0.8, 0.0, -0.6]),
    "odd angles, no rest": (0, {"roll": "10 deg", "pitch": "-25 deg", "yaw": "200 deg"}, "200 Hz", "rad/s", "g", "2 Hz", False,
                            [0.0, 0.4, -1.5]),
    "a car that shakes, few turns": (45, {"flip": "flu_to_frd"}, "100 Hz", "deg/s", "m/s^2", "1 Hz", False, [0.7, 0.4, -1.1]),
}
SHAKES = {"ride": {"roll": "0.3 deg", "pitch": "0.3 deg", "sway": "0.03 m/s", "heave": "0.05 m/s"},
          "shaking": {"standing": {"accel": 0.03, "rate": "0.05 deg/s"}, "driving": {"accel": 0.25, "rate": "0.3 deg/s"}},
          "segments": [
              {"do": "still", "duration": "45 s"}, {"do": "accelerate", "to": "11 m/s", "acceleration": "1.4 m/s^2"},
              {"do": "turn", "angle": "-90 deg", "rate": "-14 deg/s"}, {"do": "straight", "duration": "25 s"},
              {"do": "accelerate", "to": "17 m/s", "acceleration": "1.1 m/s^2"}, {"do": "climb", "height": "12 m", "duration": "25 s"},
              {"do": "turn", "angle": "110 deg", "rate": "9 deg/s"}, {"do": "straight", "duration": "35 s"},
              {"do": "accelerate", "to": 0, "acceleration": "-2 m/s^2"}, {"do": "still", "duration": "12 s"},
              {"do": "accelerate", "to": "14 m/s", "acceleration": "1.6 m/s^2"}, {"do": "turn", "angle": "80 deg", "rate": "11 deg/s"},
              {"do": "straight", "duration": "20 s"}, {"do": "turn", "angle": "-150 deg", "rate": "-10 deg/s"},
              {"do": "climb", "height": "-9 m", "duration": "20 s"}, {"do": "straight", "duration": "30 s"},
              {"do": "turn", "angle": "60 deg", "rate": "7 deg/s"}, {"do": "accelerate", "to": 0, "acceleration": "-1.8 m/s^2"}]}
# Of the simulator's fixes, when nothing else is said [m, m/s].
SIGMAS = {"positions": [1.5, 1.5], "heights": [3.0], "velocities": [0.05, 0.05, 0.1]}
# RMS after the first 60 s [m, m, deg, deg].
BOUNDS = {"horizontal": 1.0, "height": 2.0, "tilt": 0.5, "yaw": 1.0}


def drive_config(name, drive):
    rest, turn, imu_rate, rate_unit, force_unit, gnss_rate, has_deviations, lever_arm = drive
    segments = [{"do": "still", "duration": f"{rest} s"}] * (rest > 0) + (ROUTE + [{"do": "still", "duration": "5 s"}]) * 3
    start = {"lat": "48.1 deg", "lon": "11.6 deg", "height": "520 m", "heading": "130 deg"}
    # The route ends at rest: a drive without rest at its begin starts with speed.
    if rest == 0:
        start["speed"] = "5 m/s"
    source = {"type": "vehicle_simulator", "start": start, "segments": segments, "roll_gradient": "4 deg/g", "pitch_gradient": "1.5 deg/g",
              "imu_rate": imu_rate, "gnss_rate": gnss_rate, "ride": {"slip": 0.002, "heave": "0.03 m/s", "roll": "2 mrad", "pitch": "2 mrad"},
              "gyro": {"bias": "200 deg/h", "noise": "0.4 deg/sqrt(h)"}, "accel": {"bias": "5 mg", "noise": "0.08 m/s/sqrt(h)"},
              "gnss": {"lever_arm": [f"{x} m" for x in lever_arm]}}
    if name.startswith("a car that shakes"):
        source.update(SHAKES)
    fix_fields, fix_units = FIX, FIX_UNITS
    if has_deviations:
        fix_fields, fix_units = FIX + SD, fix_units + ["m"] * 3 + ["m/s"] * 3
    sinks = {
        "imu": {"type": "csv_writer", "input": "sensor", "path": "imu.csv", "time": "t_s",
                "columns": columns(IMU, [rate_unit] * 3 + [force_unit] * 3)},
        "gnss": {"type": "csv_writer", "input": "drive.gnss", "path": "gnss.csv", "time": "t_s", "columns": columns(fix_fields, fix_units)},
        "truth": {"type": "csv_writer", "input": "drive.truth", "path": "truth.csv", "time": "t_s",
                  "columns": columns(FIX + ["roll", "pitch", "yaw"], FIX_UNITS + ["deg"] * 3)}}
    for sink in sinks.values():
        for name, column in sink["columns"].items():
            column["column"] = f"{name}_{column['unit'].replace('/', 'p').replace('^', '')}" if name[0] in "wf" else \
                f"{name}_deg" if column["unit"] == "deg" else name
    return {"binnacle": 1, "sources": {"drive": source}, "filters": {}, "sinks": sinks,
            "transforms": {"sensor": {"type": "rotate_axes", "input": "drive.imu", **turn}}}


def call(command, words, folder):
    done = subprocess.run([command] + words, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"binnacle {' '.join(words)}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def errors_of(summary):
    """RMS of the errors after 60 s, against the truth."""
    figures = summary["filters"]["ins"]["reference"]
    tilt = (figures["attitude.north"]["rms"] ** 2 + figures["attitude.east"]["rms"] ** 2) ** 0.5
    return {"horizontal": figures["position.horizontal"]["rms"], "height": figures["position.down"]["rms"], "tilt": tilt,
            "yaw": figures["attitude.down"]["rms"]}


def judge(command, name, drive, seed, folder):
    (folder / "drive.json").write_text(json.dumps(drive_config(name, drive)))
    call(command, ["run", "drive.json", "--seed", str(seed), "--quiet"], folder)
    said = call(command, ["inspect", "imu.csv", "gnss.csv", "truth.csv", "--write", "proposed.json"], folder)
    call(command, ["run", "proposed.json", "--set", '/evaluate={"after": "start+60 s"}', "--summary", "summary.json", "--quiet"], folder)
    summary = json.loads((folder / "summary.json").read_text())
    ins = summary["filters"]["ins"]
    fix = ins["measurements"]["fix"]
    alignment = json.loads((folder / "proposed.json").read_text())["transforms"]["alignment"]["type"]
    refused = 1 - fix["accepted"] / fix["offered"]
    errors = errors_of(summary)
    print(f"{name}: {alignment}, verdict {ins['verdict']['state']}, {100 * refused:.2f} % of {fix['offered']} fixes refused")
    print("\n".join(line for line in said.splitlines() if line.strip().startswith(("lever arm", "noise", "alignment:", "fixes:", "lever_arm"))))
    checks = {"no warnings": "\nNo warnings\n" in said, "verdict ok": ins["verdict"]["state"] == "ok", "less than 2 % refused": refused < 0.02,
              "alignment as the record begins": (alignment == "coarse_alignment") == (drive[0] > 0)}
    if drive[0] > 0:
        for what, sigmas in SIGMAS.items():
            seen = [float(x) for x in re.search(rf"{what} scatter by ([-0-9., ]+) m", said)[1].split(",")]
            checks[f"{what} scatter by {seen}, and were drawn with {sigmas}"] = all(abs(x / y - 1) < 0.35 for x, y in zip(seen, sigmas))
    for what, bound in BOUNDS.items():
        checks[f"{what} {errors[what]:.3f} rms, below {bound}"] = errors[what] < bound
    for what, holds in checks.items():
        print(f"  {'ok  ' if holds else 'FAIL'} {what}")
    return all(checks.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, help="the files stay in this folder")
    options = parser.parse_args()
    command = str(pathlib.Path(options.command).resolve())
    is_right = True
    with tempfile.TemporaryDirectory() as temporary:
        for i, (name, drive) in enumerate(DRIVES.items()):
            folder = (options.keep or pathlib.Path(temporary)) / str(i)
            folder.mkdir(parents=True, exist_ok=True)
            is_right &= judge(command, name, drive, options.seed, folder)
    return 0 if is_right else 1


if __name__ == "__main__":
    sys.exit(main())
