#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fits the filters of the labyrinth on the first half of the recording and writes what it found into gaussian.json, huber.json, ….

    python3 configs/labyrinth/fit.py build/release/bin/binnacle ../shared/data/uwb

One parameter after another takes the value of its grid with the least horizontal RMS error over the window "first half"; that is
repeated until nothing changes. The second half is not looked at: only the first one's samples are read ("window" of the sources).
"""
import json
import pathlib
import subprocess
import sys

binnacle, data = sys.argv[1], sys.argv[2]
here = pathlib.Path(__file__).parent
RANGES = "/filters/robot/measurements/ranges"
MOTION = "/filters/robot/process/motion"
ANCHORS = ["105", "107", "108", "109"]

SIGMA = {RANGES + "/sigma": [0.02, 0.03, 0.04, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4]}
BIASES = {f"{RANGES}/anchors/{anchor}/bias": [round(0.02 * i - 0.1, 2) for i in range(23)] for anchor in ANCHORS}
ODOMETRY = {MOTION + "/speed_noise": [0.005, 0.01, 0.02, 0.05, 0.1],
            MOTION + "/yaw_rate_noise": [0.02, 0.05, 0.1, 0.2, 0.4],
            MOTION + "/turn_noise": [0, 0.05, 0.1, 0.2, 0.4]}
EFFICIENCY = {RANGES + "/noise/efficiency": [0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98]}
LOSSES = ["huber", "cauchy", "student_t", "dcs"]


def error(settings):
    """Horizontal RMS of the first half [m]."""
    command = [binnacle, "run", str(here / "base.json"), "--json", "--quiet", "--var", "uwb=" + str(pathlib.Path(data).resolve())]
    for source in ("ranges", "wheels"):
        command += ["--set", f'/sources/{source}/window=["0 s", "15 s"]']
    settings = dict(settings)
    if noise := {key: settings.pop(f"{RANGES}/noise/{key}") for key in ("type", "efficiency") if f"{RANGES}/noise/{key}" in settings}:
        settings[RANGES + "/noise"] = noise
    for pointer, value in settings.items():
        command += ["--set", f"{pointer}={json.dumps(value)}"]
    run = subprocess.run(command, capture_output=True, text=True)
    if not run.stdout:
        sys.exit(run.stderr)
    windows = json.loads(run.stdout)["filters"]["robot"]["windows"]
    return windows["first half"]["position.horizontal"]["rms"]


def fit(start, grids):
    settings, best = dict(start), error(start)
    changed = True
    while changed:
        changed = False
        for pointer, values in grids.items():
            for value in values:
                if value == settings.get(pointer):
                    continue
                tried = {**settings, pointer: value}
                if (found := error(tried)) < best - 1e-9:
                    settings, best, changed = tried, found, True
    return settings, best


def write(name, title, settings):
    patch = {}
    for pointer, value in settings.items():
        at = patch
        *path, last = pointer.strip("/").split("/")
        for key in path:
            at = at.setdefault(key, {})
        at[last] = value
    body = {"binnacle": 1, "extends": "base.json", "title": title, **patch}
    text = "// Written by fit.py: settings from the first half of the recording.\n" + json.dumps(body, indent=2) + "\n"
    (here / (name + ".json")).write_text(text)


def main():
    start = {RANGES + "/sigma": 0.1, MOTION + "/speed_noise": 0.02, MOTION + "/yaw_rate_noise": 0.1, MOTION + "/turn_noise": 0.1}
    start |= {pointer: 0.1 for pointer in BIASES}
    gaussian, rms = fit(start, {**SIGMA, **BIASES, **ODOMETRY})
    print(f"{'gaussian':10} first half {rms:.4f} m  {gaussian}", flush=True)
    write("gaussian", "The labyrinth, all noise Gaussian", gaussian)
    for loss in LOSSES:
        first = {**gaussian, RANGES + "/noise/type": loss, RANGES + "/noise/efficiency": 0.9}
        settings, rms = fit(first, {**SIGMA, **BIASES, **EFFICIENCY})
        print(f"{loss:10} first half {rms:.4f} m  {settings}", flush=True)
        write(loss, f"The labyrinth, a robust loss: {loss}", settings)


main()
