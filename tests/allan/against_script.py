#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Allan deviations of a recorded IMU, as `binnacle allan` prints them, against their definition in plain Python."""
import argparse
import csv
import gzip
import json
import math
import os
import pathlib
import subprocess
import sys

project = pathlib.Path(__file__).resolve().parents[2]
drive = "urban-stop-go-large-mount-001"
begin, end = 20.0, 118.0  # the car stands


def deviation(means, m, stride):
    """Square root of half the mean square of differences between neighbouring means over m intervals, one each stride."""
    sums = [0.0]
    for mean in means:
        sums.append(sums[-1] + mean)
    squares = [((sums[k + 2 * m] - 2 * sums[k + m] + sums[k]) / m) ** 2 for k in range(0, len(means) - 2 * m + 1, stride)]
    return math.sqrt(math.fsum(squares) / len(squares) / 2)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--binary", required=True)
    options = options.parse_args()
    drives = pathlib.Path(os.environ.get("BINNACLE_DATA") or project / "../shared/data") / "drives"
    record = drives / drive / "imu.csv.gz"
    if not record.exists():
        print(f"skipped: no {record}")
        sys.exit(77)
    printed = subprocess.run(
        [options.binary, "allan", project / "configs/drives/base.json", "--var", f"drives={drives}", "--var", f"drive={drive}",
         "--channel", "raw_imu", "--set", f'/sources/raw_imu/window=["{begin} s", "{end} s"]', "--overlap", "1", "--json"],
        check=True, capture_output=True, text=True).stdout
    channel = json.loads(printed)
    with gzip.open(record, "rt") as file:
        rows = [row for row in csv.DictReader(file) if begin <= float(row["t_s"]) <= end]
    assert len(rows) == channel["samples"], (len(rows), channel["samples"])
    compared = 0
    for field, column in {"wx": "gx_radps", "wz": "gz_radps", "fy": "ay_mps2"}.items():
        means = [float(row[column]) for row in rows]
        for point in channel["fields"][field]["points"]:
            m = round(point["tau_s"] / channel["interval_s"])
            # Beyond a second: the largest power of 2 that divides m and is at most a sixteenth of it.
            stride = 1 if point["tau_s"] <= 1 else max(2**k for k in range(20) if 16 * 2**k <= m and m % 2**k == 0)
            expected = deviation(means, m, stride)
            assert abs(point["deviation"] - expected) <= 1e-9 * expected, (field, point, expected, stride)
            compared += 1
    print(f"{compared} deviations of {len(rows)} samples agree")
    assert compared > 40


if __name__ == "__main__":
    main()
