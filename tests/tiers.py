#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests by tests/tiers.txt: `tests/tiers.py [--build DIR] [--tiers FILE] [--measured | --write]`.

Without an option: each test that ctest has in DIR (build/release) has exactly one line, its label `quick` is that of the line,
each pattern of cases matches one, and no line is left over; exit status 1 if not. --measured prints what each line cost in the
last run of tests/run there, in units, and the dearest cases; --write puts those units into the file. A unit is taken from
DIR/unit.txt, which tests/run leaves.
"""
import argparse
import fnmatch
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
LINE = re.compile(r"^(quick|all) +([0-9]+\.?[0-9]*) +([^][#;]*[^][#; ]) +# (\S.*)$")
OF_CASES = re.compile(r"^(\w+: cases): (.*)$")
SPLIT = re.compile(r"^(\w+: cases), (quick|all)$")


class Line:
    def __init__(self, number, match):
        self.number, self.tier, self.units, self.pattern = number, match[1], float(match[2]), match[3]
        of_cases = OF_CASES.match(self.pattern)
        self.executable, self.case_pattern = of_cases.groups() if of_cases else (None, None)

    def takes(self, test):
        return self.executable is None and matches(test, self.pattern)


def matches(name, pattern):
    return fnmatch.fnmatchcase(name, pattern.replace("?", "[?]"))


def lines_of(file):
    lines, wrong = [], []
    for number, text in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        if not text.strip() or text.startswith("#"):
            continue
        match = LINE.match(text)
        if match:
            lines.append(Line(number, match))
        else:
            wrong.append(f"line {number}: not understood: {text}")
    return lines, wrong


def tests_of(build):
    """{name: labels} of ctest."""
    said = subprocess.run(["ctest", "--test-dir", str(build), "--show-only=json-v1"], capture_output=True, text=True, check=True).stdout
    tests = {}
    for test in json.loads(said)["tests"]:
        properties = {entry["name"]: entry["value"] for entry in test.get("properties", [])}
        tests[test["name"]] = properties.get("LABELS", [])
    return tests


def wrong_tests(lines, tests):
    for test, labels in tests.items():
        split = SPLIT.match(test)
        if split:
            expected = split[2]
        else:
            taking = [line for line in lines if line.takes(test)]
            if len(taking) != 1:
                numbers = ", ".join(str(line.number) for line in taking)
                yield f"'{test}' has {'no line' if not taking else 'the lines ' + numbers}"
                continue
            expected = taking[0].tier
        if (expected == "quick") != ("quick" in labels):
            yield f"'{test}' is {expected}, and ctest's labels of it are {' '.join(sorted(labels))}: does its folder call binnacle_tiers()?"


def cases_of(build):
    """{"LABEL: cases": names} of the executables that are built."""
    cases = {}
    file = build / "tests" / "executables.txt"
    for text in file.read_text(encoding="utf-8").splitlines() if file.exists() else []:
        label, path = text.split(" ", 1)
        if Path(path).exists():
            said = subprocess.run([path, "--list-test-names-only"], capture_output=True, text=True).stdout
            if "All available test cases" in said or not said:  # Catch2 v3 has another option
                said = subprocess.run([path, "--list-tests", "--verbosity", "quiet"], capture_output=True, text=True).stdout
            cases[f"{label}: cases"] = [name.strip() for name in said.splitlines() if name.strip()]
    return cases


def stale_lines(lines, tests, cases):
    for line in lines:
        if line.executable is None:
            if not any(line.takes(test) for test in tests):
                yield f"line {line.number}: no test is named '{line.pattern}'"
            continue
        if "*" in line.case_pattern[1:-1]:
            yield f"line {line.number}: Catch2 takes a * at the ends of a pattern only"
        if line.executable not in tests:
            yield f"line {line.number}: there is no '{line.executable}'"
        elif line.executable in cases and not any(matches(case, line.case_pattern) for case in cases[line.executable]):
            yield f"line {line.number}: no case of {line.executable} is named '{line.case_pattern}'"


def check(lines, wrong, build, is_complete):
    tests = tests_of(build)
    wrong += wrong_tests(lines, tests)
    if is_complete:
        wrong += stale_lines(lines, tests, cases_of(build))
    for text in wrong:
        print(f"tests/tiers.txt: {text}")
    print(f"{len(tests)} tests, {sum('quick' in labels for labels in tests.values())} of them quick")
    return 1 if wrong or not tests else 0


def measured(build):
    """({test: seconds}, {"LABEL: cases": {case: seconds}}) of the last run: processor time of cases, wall time of other tests."""
    tests, cases = {}, {}
    for file in sorted(build.glob("tests-*.xml")):
        for test in xml.parse(file).iter("testcase"):
            tests[test.get("name")] = float(test.get("time") or 0)
    for file in sorted((build / "junit").glob("*.xml")):
        executable = re.sub(r"_cases(_quick|_all)?$", ": cases", file.stem)
        text = file.read_text(encoding="utf-8")
        if "</testsuite>" not in text:
            text += "</testsuite>"
        of_file = cases.setdefault(executable, {})
        for case in xml.fromstring(text).iter("testcase"):
            if case.get("processor"):
                of_file[case.get("name")] = float(case.get("processor"))
    return tests, {name: found for name, found in cases.items() if found}


def seconds_of(line, lines, tests, cases):
    """Of all that the line names."""
    if line.executable:
        return sum(time for case, time in cases.get(line.executable, {}).items() if matches(case, line.case_pattern))
    if line.pattern in cases:  # all cases but those that have lines of their own
        own = [other.case_pattern for other in lines if other.executable == line.pattern]
        return sum(time for case, time in cases[line.pattern].items() if not any(matches(case, pattern) for pattern in own))
    return sum(time for test, time in tests.items() if line.takes(test))


def show(lines, build):
    unit = float((build / "unit.txt").read_text())
    tests, cases = measured(build)
    totals = {"quick": 0.0, "all": 0.0}
    for line in lines:
        units = seconds_of(line, lines, tests, cases) / unit
        totals[line.tier] += units
        print(f"{line.tier:5} {units:7.2f}  {line.pattern}")
    print(f"a unit is {unit:.2f} s; quick {totals['quick']:.1f}, the rest {totals['all']:.1f} units. The dearest cases:")
    every = [(time / unit, name, case) for name, found in cases.items() for case, time in found.items()]
    every += [(time / unit, name, "") for name, time in tests.items() if name not in cases and not SPLIT.match(name)]
    for units, name, case in sorted(every, reverse=True)[:60]:
        print(f"{units:8.2f}  {name}{': ' + case if case else ''}")


def write(lines, build, file):
    unit = float((build / "unit.txt").read_text())
    tests, cases = measured(build)
    texts = file.read_text(encoding="utf-8").splitlines()
    for line in lines:
        seconds = seconds_of(line, lines, tests, cases)
        if seconds > 0:
            units = f"{max(0.1, seconds / unit):4.1f}"
            texts[line.number - 1] = re.sub(r"^(quick|all) +[0-9.]+ +", lambda head: f"{head[1]:5} {units}  ", texts[line.number - 1])
    file.write_text("\n".join(texts) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(prog="tests/tiers.py", description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=Path, default=PROJECT / "build" / "release")
    parser.add_argument("--tiers", type=Path, default=PROJECT / "tests" / "tiers.txt")
    parser.add_argument("--partial", action="store_true", help="a build that lacks tests: lines may be left over")
    parser.add_argument("--measured", action="store_true")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    lines, wrong = lines_of(options.tiers)
    if options.measured:
        show(lines, options.build)
    elif options.write:
        write(lines, options.build, options.tiers)
    else:
        sys.exit(check(lines, wrong, options.build, not options.partial))


if __name__ == "__main__":
    main()
