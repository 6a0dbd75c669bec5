#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The summary of a test run: summary.py NAME LOG BUILD SECONDS STATUS

LOG is what tests/run printed; in the folders of BUILD, LastTest.log of ctest has why a test was skipped, and junit the cases of tests
that run several in one process. Exit status 1 if a test failed, or none ran.
"""
import re
import sys
import xml.etree.ElementTree as xml
from collections import Counter
from pathlib import Path

RESULT = re.compile(r"^ *\d+/\d+ Test +#\d+: (.*?) \.+ *(Passed|\*\*\*\w[\w ]*?|Skipped) +[\d.]+ sec", re.MULTILINE)
BLOCK = re.compile(r"^\d+/\d+ Testing: (.*?)\n(.*?)^<end of output>", re.MULTILINE | re.DOTALL)


def outcomes(text):
    """{name: Passed, Skipped, or how it failed}; the last of several runs counts."""
    return {name.strip(): how.strip("* ") for name, how in RESULT.findall(text)}


def reasons(build):
    """{name: the line that says why it was skipped}"""
    found = {}
    for log in sorted(Path(build).glob("*/Testing/Temporary/LastTest.log")):
        for name, output in BLOCK.findall(log.read_text(errors="replace")):
            why = re.search(r"^.*SKIPPED: *(.+)$|^\s*explicitly with message:\n\s*(.+)$", output, re.MULTILINE)
            if why:
                found[name.strip()] = (why[1] or why[2]).strip()
    return found


def cases(build):
    """How many cases JUnit files have, how many failed, and why others were skipped: {reason: count}"""
    count, failed, skipped = 0, 0, Counter()
    for file in sorted(Path(build).glob("*/junit/*.xml")):
        for case in xml.parse(file).iter("testcase"):
            count += 1
            failed += case.find("failure") is not None or case.find("error") is not None
            if (skip := case.find("skipped")) is not None:
                skipped[(skip.get("message") or "no reason was printed").split("\n")[0]] += 1
    return count, failed, skipped


def main():
    name, log, build, seconds, status = sys.argv[1:]
    results = outcomes(Path(log).read_text(errors="replace"))
    passed = [test for test, how in results.items() if how == "Passed"]
    skipped = [test for test, how in results.items() if how == "Skipped"]
    failed = {test: how for test, how in results.items() if how not in ("Passed", "Skipped")}
    print(f"{'system':10}{'run':>6}{'passed':>8}{'failed':>8}{'skipped':>9}{'s':>7}  exit status")
    print(f"{name:10}{len(results):6}{len(passed):8}{len(failed):8}{len(skipped):9}{seconds:>7}  {status}")
    count, failed_cases, skipped_cases = cases(build)
    if count:
        print(f"cases in tests of several: {count} run, {failed_cases} failed, {skipped_cases.total()} skipped")
    for test, how in failed.items():
        print(f"failed: {test} ({how})")
    why = reasons(build)
    for test in skipped:
        print(f"skipped: {test}: {why.get(test, 'no reason was printed')}")
    for reason, times in skipped_cases.most_common():
        print(f"skipped: {times} cases: {reason}")
    return 1 if failed or not results else 0


sys.exit(main())
