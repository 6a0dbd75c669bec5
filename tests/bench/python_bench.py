#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a run costs from Python, against the command: `tests/bench/python_bench.py [SECONDS] [PAIRS]`. Processor time of pairs of
runs of at least so many seconds, one after the other, the import left out; the median of their ratios. Once where both keep figures
alone, once where both keep everything: the command in a folder, the package in memory."""
import os
import resource
import statistics
import subprocess
import sys
import tempfile

BINNACLE = os.path.abspath(os.environ.get("BINNACLE", "build/release/bin/binnacle"))
PROJECT = os.path.abspath(os.environ.get("PROJECT", "."))
CONFIG = f"{PROJECT}/configs/quickstart.json"
CHILD = """
import resource, sys
import binnacle as bn
def spent():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime
before = spent()
keeps = sys.argv[3] == "all"
result = bn.load(sys.argv[1], set={"/sources/drive/repeat": int(sys.argv[2])}).run(records=keeps, innovations=keeps)
steps = result.summary["filters"]["ins"]["steps"]
print(spent() - before, steps, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def command(repeat, *more):
    before = children()
    subprocess.run([BINNACLE, "run", CONFIG, "--set", f"/sources/drive/repeat={repeat}", "--quiet", *more], check=True)
    return children() - before


def package(repeat, kept):
    done = subprocess.run([sys.executable, "-c", CHILD, CONFIG, str(repeat), kept], check=True, capture_output=True, text=True)
    seconds, steps, memory = done.stdout.split()
    return float(seconds), int(steps), int(memory)


def compare(what, repeat, pairs, kept, *more):
    ratios, ours, theirs = [], [], []
    for pair in range(pairs):
        if pair % 2:
            theirs.append(command(repeat, *more))
        seconds, steps, memory = package(repeat, kept)
        ours.append(seconds)
        if not pair % 2:
            theirs.append(command(repeat, *more))
        ratios.append(ours[-1] / theirs[-1])
    print(f"{what}: {steps} steps, Python {statistics.median(ours):.2f} s, command {statistics.median(theirs):.2f} s, ratio "
          f"{statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f}, {pairs} pairs), {memory / 1024:.0f} MB")


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 5
    pairs = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    repeat = 1
    while (spent := command(repeat)) < seconds:
        repeat = max(repeat + 1, int(repeat * min(8.0, 1.1 * seconds / max(spent, 0.01))))
    with tempfile.TemporaryDirectory() as folder:
        compare("figures alone", repeat, pairs, "none")
        compare("everything kept", repeat, pairs, "all", "--out", f"{folder}/out")


if __name__ == "__main__":
    main()
