#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A budget of instructions: `budget.py BENCH COMPILER [--update]` counts by callgrind those of an IMU step, an update, a push
and a line of csv, and fails where one is more than 2 % beyond budget.json. Counts of instructions do not depend on what
else the machine does, but on compiler, C library and processor: without a reference for these it is skipped (77), and
--update writes one. Below the budget by more than 2 % fails too: then --update makes the gain the new budget.
"""
import json
import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

BUDGET = Path(__file__).with_name("budget.json")
COUNTS = {"step": 2000, "update": 2000, "push": 20000, "csv": 20000}
SLACK = 0.02
SKIPPED = 77


def machine(compiler):
    """What the instructions depend on. AVX2 is chosen at run time."""
    flags = Path("/proc/cpuinfo").read_text().split() if Path("/proc/cpuinfo").exists() else []
    return " ".join([compiler, platform.machine(), "glibc", platform.libc_ver()[1], "avx2" if "avx2" in flags else "baseline"])


def instructions(bench, what):
    count = COUNTS[what]
    done = subprocess.run(
        ["valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=budget_work", "--callgrind-out-file=/dev/null",
         bench, what, str(count)], capture_output=True, text=True)
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not collected or int(collected[1]) == 0:
        sys.exit(f"{what}: callgrind counted nothing (exit status {done.returncode}):\n{done.stderr}")
    return int(collected[1]) / count


def main():
    bench, compiler = sys.argv[1:3]
    if not shutil.which("valgrind"):
        print("skipped: valgrind is not installed (Debian: valgrind)")
        return SKIPPED
    budgets = json.loads(BUDGET.read_text())
    here = machine(compiler)
    counted = {what: round(instructions(bench, what), 1) for what in COUNTS}
    if "--update" in sys.argv[3:]:
        budgets[here] = counted
        BUDGET.write_text(json.dumps(budgets, indent=2, sort_keys=True) + "\n")
    budget = budgets.get(here)
    if budget is None:
        print(f"skipped: budget.json has no reference for '{here}'; counted here: {json.dumps(counted)}")
        return SKIPPED
    beyond = 0
    for what, count in counted.items():
        change = count / budget[what] - 1
        beyond += abs(change) > SLACK
        verdict = "" if abs(change) <= SLACK else "  beyond the budget" if change > 0 else "  a gain: budget.py --update keeps it"
        print(f"{what:8}{count:12.1f} instructions each, budget {budget[what]:.1f} ({100 * change:+.2f} %){verdict}")
    return 1 if beyond else 0


if __name__ == "__main__":
    os.environ.pop("BINNACLE_PLUGIN_PATH", None)
    sys.exit(main())
