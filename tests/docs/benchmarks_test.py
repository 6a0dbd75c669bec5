#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""configs/benchmarks: its README's table is what the command prints, and a row that is wrong fails by name.

Rows that take long are compared in their words alone; their figures are the command's. What has no data here is skipped (77).
"""
import importlib.machinery
import importlib.util
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[2] / "configs" / "benchmarks"
RUN = FOLDER / "run"
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")
untried = []


def ran(*words):
    """The command, on this build."""
    return subprocess.run([sys.executable, str(RUN), "--binnacle", os.environ["BINNACLE"], *words], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, check=False)


def module():
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader("benchmarks_run", str(RUN))
    loaded = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(loaded)
    return loaded


def rows_of(text):
    """{name: its cells} of the Markdown table in a text."""
    lines = [line for line in text.splitlines() if re.match(r"\| `[^`]+`: ", line)]
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    return {re.match(r"`([^`]+)`", row[0])[1]: row for row in cells}


def last_digit(text):
    """What one more in the last digit is of a printed number."""
    mantissa, _, exponent = text.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def differ(one, other):
    """Whether two texts differ by more than one in the last digit of a figure."""
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return True
    return any(abs(float(a) - float(b)) > 1.01 * last_digit(a)
               for a, b in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True))


def stray_figures(text, page):
    """Lines of a table elsewhere that name a row of the page, as `NAME`, and have another figure than it."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [line for line in lines for name, cells in page.items() if f"`{name}`" in line and cells[1].strip("*") not in line]


class Page(unittest.TestCase):
    text = (FOLDER / "README.md").read_text(encoding="utf-8")

    def test_the_table_has_every_row_and_its_words(self):
        page, table = rows_of(self.text), json.loads((FOLDER / "rows.json").read_text(encoding="utf-8"))
        self.assertEqual(list(page), [row["name"] for row in table["rows"]])
        for row in table["rows"]:
            about = table["data"][row.get("data", "simulated")]
            what, figure, _, settings, data = page[row["name"]]
            self.assertEqual(what, f"`{row['name']}`: {row['what']}")
            self.assertEqual(settings, row["settings"])
            self.assertEqual(data, f"{about['source']}; {about['licence']}")
            self.assertRegex(figure, r"^\*\*[^*]*\d[^*]*\*\*$")
            self.assertNotRegex(figure, "skipped|failed")

    def test_the_figures_are_those_of_the_command(self):
        done = ran("--quick", "--markdown")
        self.assertEqual(done.returncode, 0, done.stderr)
        page, printed = rows_of(self.text), rows_of(done.stdout)
        self.assertGreater(len(printed), 8)
        for name, cells in printed.items():
            if "skipped: no " in cells[1]:
                untried.append(f"{name}: {cells[1]}")
                self.assertIn(f"{name}: skipped: no ", done.stderr)
                continue
            for here, there in zip(cells, page[name], strict=True):
                self.assertFalse(differ(there, here), f"{name}: the page has {there}, the command prints {here}")

    def test_the_table_of_the_page_on_accuracy_has_its_figures(self):
        page, accuracy = rows_of(self.text), FOLDER.parents[1] / "sdk/docs/evidence/accuracy.md"
        self.assertEqual(stray_figures(accuracy.read_text(encoding="utf-8"), page), [])
        name, cells = next(iter(page.items()))
        self.assertEqual(len(stray_figures(f"| `{name}` | {cells[1]} |\n| `{name}` | 0.01 m |", page)), 1)

    def test_its_commands_are_understood(self):
        commands = [line.partition(" #")[0] for line in self.text.splitlines() if line.startswith("configs/benchmarks/run")]
        self.assertGreater(len(commands), 2)
        for command in commands:
            done = ran(*shlex.split(command)[1:], "--commands")
            self.assertEqual(done.returncode, 0, f"{command}: {done.stderr}")
            self.assertIn("binnacle", done.stdout)


class Comparison(unittest.TestCase):
    def test_a_figure_may_differ_by_one_in_its_last_digit_and_no_more(self):
        self.assertFalse(differ("07: 0.78 %", "07: 0.79 %"))
        self.assertTrue(differ("07: 0.78 %", "07: 0.80 %"))
        self.assertTrue(differ("6.53e-05 deg", "6.55e-05 deg"))
        self.assertTrue(differ("0.78 %", "0.78 m"))


class Rows(unittest.TestCase):
    good = {"name": "start", "what": "the quickstart", "settings": "its own", "unit": "m",
            "cases": [{"config": "quickstart.json", "at": ["filters", "ins", "reference", "position.horizontal", "rms"]}]}
    data = {"simulated": {"source": "simulated", "licence": "Apache-2.0"}, "drives": {"source": "recorded", "licence": "MIT"}}

    def of(self, *rows, options=()):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "rows.json"
            file.write_text(json.dumps({"data": self.data, "rows": rows}), encoding="utf-8")
            return ran("--rows", str(file), *options)

    def spoilt(self, **changes):
        return {**self.good, "name": "spoilt", "cases": [{**self.good["cases"][0], **changes}]}

    def test_a_good_row_has_its_figure(self):
        done = self.of(self.good)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"(?m)^start: 0\.\d{3} m$")

    def test_a_row_without_its_config_fails_and_the_others_run(self):
        done = self.of(self.spoilt(config="none.json"), self.good)
        self.assertEqual(done.returncode, 1)
        self.assertIn("failed: spoilt: configs/none.json: configs/none.json is not there", done.stderr)
        self.assertRegex(done.stdout, r"(?m)^start: 0\.\d{3} m$")

    def test_a_row_whose_figure_is_not_in_the_summary_fails(self):
        done = self.of(self.spoilt(at=["filters", "ins", "reference", "position.sideways", "rms"]))
        self.assertEqual(done.returncode, 1)
        self.assertIn("failed: spoilt: configs/quickstart.json: no 'position.sideways' in its summary", done.stderr)
        self.assertEqual(self.of(self.spoilt(at=["filters", "ins"])).returncode, 1)

    def test_a_row_whose_command_fails_has_its_message(self):
        done = self.of(self.spoilt(set={"/filters/ins/measurements/fix/gate": 2}))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "failed: spoilt: .* exit status 3")

    def test_a_row_with_nothing_of_a_paper_to_hold_fails(self):
        done = self.of(self.spoilt(criterion={"part": 0.1}))
        self.assertEqual(done.returncode, 1)
        self.assertIn("failed: spoilt: configs/quickstart.json: no table with figures of a paper", done.stderr)

    def test_a_row_without_data_is_skipped_by_name(self):
        done = self.of({**self.good, "data": "drives"}, options=("--data", "/nonexistent"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("start: skipped: no /nonexistent/drives", done.stdout)
        self.assertIn("start: skipped: no /nonexistent/drives", done.stderr)

    def test_an_unknown_name_is_a_usage_error(self):
        done = ran("--only", "nothing-of-that-name")
        self.assertEqual(done.returncode, 2)
        self.assertIn("drives-withheld", done.stderr)

    def test_cells_hold_within_what_the_criterion_allows(self):
        table = {"columns": ["a ", "b"], "cells": [[1.0, 5.0], [2.0, 5.0]], "se": [[0.1, 0.1], [0.1, 0.1]], "paper": [[1.1, None], [2.5, 9.0]]}
        cells_of = module().cells_of
        self.assertEqual(cells_of({"table": table, "runs": 4}, {"paper_runs": 4}), (1, 3))
        self.assertEqual(cells_of({"table": table, "runs": 40}, {"paper_runs": 4, "columns": ["a"]}), (2, 2))
        self.assertEqual(cells_of({"table": table}, {"part": 0.01}), (0, 3))


if __name__ == "__main__":
    outcome = unittest.main(exit=False, verbosity=2).result
    for line in untried:
        print(f"SKIPPED: {line}")
    sys.exit(1 if not outcome.wasSuccessful() else 77 if untried else 0)
