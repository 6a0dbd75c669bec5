#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fits the filters of the labyrinth on the first half of the recording and writes gaussian.json, huber.json, … with what it found.

    python3 configs/labyrinth/fit.py build/release/bin/binnacle ../shared/data/uwb

Of the samples up to 15 s alone:
- an anchor's bias is the mean, or the median, of range less true distance;
- of both, of each sigma and, of a loss, of each efficiency, those with the least horizontal RMS error of the filter are taken.
"""
import json
import math
import pathlib
import statistics
import subprocess
import sys

END = 15.0  # s, of the first half
SIGMAS = [0.02, 0.03, 0.04, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4]
LOCATIONS = {"mean": statistics.mean, "median": statistics.median}
EFFICIENCIES = [0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98]
LOSSES = ["huber", "cauchy", "student_t", "dcs"]


def residuals(data):
    """By anchor: range less true distance, up to END."""
    lines = [line.split() for line in (data / "labyrinth_input.txt").read_text().splitlines()]
    truth = {row[1]: (float(row[2]), float(row[3]))
             for row in (line.split() for line in (data / "labyrinth_truth.txt").read_text().splitlines())}
    found = {}
    for row in lines:
        if row[0] == "range2" and float(row[1]) <= END:
            distance = math.dist(truth[row[1]], (float(row[4]), float(row[5])))
            found.setdefault(row[6], []).append(float(row[2]) - distance)
    return found


class Fit:
    def __init__(self, binnacle, data):
        self.binnacle, self.data = binnacle, data
        self.here = pathlib.Path(__file__).parent
        by_anchor = residuals(data)
        scatter = math.sqrt(statistics.mean(statistics.pvariance(values) for values in by_anchor.values()))
        print(f"ranges scatter by {scatter:.3f} m about each anchor's mean")
        self.biases = {name: {key: {"bias": round(of(values), 4)} for key, values in sorted(by_anchor.items())}
                       for name, of in LOCATIONS.items()}

    def error(self, ranges):
        """Horizontal RMS of the first half [m] with these members of the measurement."""
        command = [self.binnacle, "run", str(self.here / "base.json"), "--json", "--quiet", "--var", f"uwb={self.data}"]
        for source in ("ranges", "wheels"):
            command += ["--set", f'/sources/{source}/window=["0 s", "{END} s"]']
        at = "/filters/robot/measurements/ranges"
        command += ["--set", f"{at}/sigma={ranges['sigma']}"]
        for key, anchor in ranges["anchors"].items():
            command += ["--set", f"{at}/anchors/{key}/bias={anchor['bias']}"]
        if "noise" in ranges:
            command += ["--set", f"{at}/noise={json.dumps(ranges['noise'])}"]
        run = subprocess.run(command, capture_output=True, text=True)
        if not run.stdout:
            sys.exit(run.stderr)
        return json.loads(run.stdout)["filters"]["robot"]["windows"]["first half"]["position.horizontal"]["rms"]

    def best(self, noises):
        """Of all, the least; of equal ones the first."""
        tried = [({"sigma": sigma, "anchors": self.biases[location], **noise}, location)
                 for location in LOCATIONS for sigma in SIGMAS for noise in noises]
        return min(((self.error(ranges), i, ranges, location) for i, (ranges, location) in enumerate(tried)))

    def write(self, name, title, noises):
        rms, _, ranges, location = self.best(noises)
        print(f"{name:10} sigma {ranges['sigma']:.2f} m, biases by {location:6}, {ranges.get('noise', {}).get('efficiency', '-')!s:4} "
              f"first half {rms:.4f} m", flush=True)
        body = {"binnacle": 1, "extends": "base.json", "title": title, "filters": {"robot": {"measurements": {"ranges": ranges}}}}
        (self.here / f"{name}.json").write_text(
            "// Written by fit.py, from the first half of the recording.\n" + json.dumps(body, indent=2) + "\n")


def main():
    fit = Fit(sys.argv[1], pathlib.Path(sys.argv[2]).resolve())
    fit.write("gaussian", "The labyrinth, all noise Gaussian", [{}])
    for loss in LOSSES:
        fit.write(loss, f"The labyrinth, a robust loss: {loss}",
                  [{"noise": {"type": loss, "efficiency": efficiency}} for efficiency in EFFICIENCIES])


main()
