#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The data of drive.json in a folder: `data.py FOLDER [EPOCHS]`. BINNACLE is the command.

imu.csv has EPOCHS (672 399) increments of 5 ms with ten digits, as a recorder writes them, and gnss.csv the fixes meanwhile.
"""
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent


def head(source, target, count, change):
    with open(source) as rows, open(target, "w") as out:
        out.write(next(rows))
        for _, row in zip(range(count), rows):
            out.write(change(row))


def increments(row):
    t, *rates = row.split(",")
    return ",".join([t, *(f"{0.005 * float(rate):.9e}" for rate in rates)]) + "\n"


def prepare(folder, epochs=672399):
    folder.mkdir(parents=True, exist_ok=True)
    command = os.environ.get("BINNACLE", "binnacle")
    subprocess.run([command, "run", HERE / "simulate.json", "--var", f"data={folder}", "--quiet"], check=True)
    head(folder / "rates.csv", folder / "imu.csv", epochs, increments)
    (folder / "gnss.csv").rename(folder / "fixes.csv")
    head(folder / "fixes.csv", folder / "gnss.csv", epochs // 200, lambda row: row)
    for name in ("rates.csv", "fixes.csv"):
        (folder / name).unlink()


if __name__ == "__main__":
    prepare(Path(sys.argv[1]).resolve(), *map(int, sys.argv[2:3]))
