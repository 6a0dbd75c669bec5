#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What it costs to start: `tests/bench/start.py [--runs N] [--json]`. Processor time, user and system, of `binnacle version`, of `check`
and `run` of the quickstart, and of /bin/true, which is what the system takes for any program, in turn N times; the median of each and
how many libraries were loaded. A line each, or JSON."""
import argparse
import json
import os
import re
import statistics
import subprocess
import sys

BINNACLE = os.path.abspath(os.environ.get("BINNACLE", "build/release/bin/binnacle"))
PROJECT = os.path.abspath(os.environ.get("PROJECT", "."))
CONFIG = f"{PROJECT}/configs/quickstart.json"
COMMANDS = {"version": [BINNACLE, "version"], "check": [BINNACLE, "check", CONFIG], "run": [BINNACLE, "run", CONFIG, "--quiet"], "true": ["/bin/true"]}


def processor_ms(words):
    """Of one process; ends the program where it fails."""
    child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        sys.exit(f"'{' '.join(words)}' ended with {child.returncode}")
    return 1e3 * (usage.ru_utime + usage.ru_stime)


def libraries(words):
    """That the loader initialized, the program itself left out."""
    environment = {**os.environ, "LD_DEBUG": "files"}
    done = subprocess.run(words, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    return len(set(re.findall(r"calling init: (\S+)", done.stderr)))


def figures(runs):
    times = {name: [] for name in COMMANDS}
    for _ in range(runs):
        for name, words in COMMANDS.items():
            times[name].append(processor_ms(words))
    return {name: {"runs": runs, "median_ms": statistics.median(of_one), "least_ms": min(of_one), "libraries": libraries(COMMANDS[name])}
            for name, of_one in times.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=50, metavar="N")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if options.runs < 1:
        parser.error("--runs takes 1 or more")
    found = figures(options.runs)
    if options.json:
        print(json.dumps(found, indent=2))
        return
    for name, one in found.items():
        print(f"{name:8} {one['median_ms']:6.2f} ms of processor time (median of {one['runs']}, least {one['least_ms']:.2f}), {one['libraries']} libraries")


if __name__ == "__main__":
    main()
