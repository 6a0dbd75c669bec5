# SPDX-License-Identifier: Apache-2.0
"""What the comparison must find: python3 compare_test.py"""
import importlib.machinery
import importlib.util
import os
import sys
import tempfile
import types
import unittest
from pathlib import Path
from unittest import mock

sys.dont_write_bytecode = True
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import commands  # noqa: E402
import figures  # noqa: E402
import trees  # noqa: E402
from names import Allowed, Bad, Renames  # noqa: E402

loader = importlib.machinery.SourceFileLoader("compare_run", str(HERE / "run"))
run = importlib.util.module_from_spec(importlib.util.spec_from_loader("compare_run", loader))
loader.exec_module(run)

SUMMARY = """{ "filters": { "ins": { "reference": { "position.north": { "p50": 0.2525031494006317, "n": 13985, "unit": "m" } },
  "steps": 49751, "filter_s": 0.11 } }, "warnings": ["a.json:1:2: warning[B077] /x: old words"], "wall_s": 0.2 }"""
TABLE = "t[s],position.lat.sigma[rad]\n0.1,1.5e-3\n0.2,0.1\n"


class Folders(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)

    def compared(self, old, new, renames=None):
        """old, new: {file name: text}."""
        for side, files in (("old", old), ("new", new)):
            for name, text in files.items():
                path = self.folder / side / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
        return figures.compare_folders(self.folder / "old", self.folder / "new", Renames(renames or {}))

    def places(self, *arguments, **named):
        return [d.place for d in self.compared(*arguments, **named).differences]


class Summaries(Folders):
    def summaries(self, new, renames=None, old=SUMMARY):
        return self.places({"summary.json": old}, {"summary.json": new}, renames)

    def test_same_but_for_times_and_wording(self):
        new = SUMMARY.replace("0.11", "0.22").replace('"wall_s": 0.2', '"wall_s": 0.3').replace("old words", "new words")
        result = self.compared({"summary.json": SUMMARY}, {"summary.json": new})
        self.assertEqual(result.differences, [])
        self.assertEqual(result.values, 3)

    def test_last_digit(self):
        result = self.compared({"summary.json": SUMMARY}, {"summary.json": SUMMARY.replace("0.2525031494006317", "0.2525031494006318")})
        self.assertEqual([d.place for d in result.differences], ["summary.json#/filters/ins/reference/position.north/p50"])
        self.assertLess(0, result.differences[0].relative)
        self.assertLess(result.differences[0].relative, 1e-15)

    def test_count(self):
        self.assertEqual(len(self.summaries(SUMMARY.replace("13985", "13986"))), 1)

    def test_large_counts_beyond_a_double(self):
        self.assertFalse(figures.same_number("9007199254740993", "9007199254740992"))

    def test_written_otherwise(self):
        self.assertTrue(figures.same_number("2", "2.0"))
        self.assertTrue(figures.same_number("1e-3", "0.001"))
        self.assertFalse(figures.same_number("0.0", "-0.0"))
        self.assertFalse(figures.same_number("0", "-0"))

    def test_unit(self):
        self.assertEqual(len(self.summaries(SUMMARY.replace('"m"', '"mm"'))), 1)

    def test_number_that_becomes_text(self):
        self.assertEqual(len(self.summaries(SUMMARY.replace("49751", '"49751"'))), 1)

    def test_code_of_a_warning(self):
        self.assertEqual(self.summaries(SUMMARY.replace("B077", "B078")), ["summary.json#/warnings"])

    def test_missing_key(self):
        self.assertEqual(self.summaries(SUMMARY.replace('"n": 13985, ', "")), ["summary.json#/filters/ins/reference/position.north/n"])

    def test_missing_object(self):
        self.assertEqual(len(self.summaries('{ "warnings": [] }')), 5)

    def test_new_key(self):
        self.assertEqual(self.summaries(SUMMARY.replace('"n"', '"more": 1, "n"')), ["summary.json#/filters/ins/reference/position.north/more"])

    def test_renamed_key(self):
        new = SUMMARY.replace('"p50"', '"median"')
        self.assertEqual(len(self.summaries(new)), 2)
        self.assertEqual(self.summaries(new, {"names": {"p50": "median"}}), [])
        self.assertEqual(len(self.summaries(SUMMARY, {"names": {"p50": "median"}})), 2)

    def test_renamed_key_with_another_number(self):
        new = SUMMARY.replace('"p50": 0.2525031494006317', '"median": 0.2525031494006316')
        self.assertEqual(len(self.summaries(new, {"names": {"p50": "median"}})), 1)

    def test_renamed_machine_time(self):
        self.assertEqual(self.summaries(SUMMARY.replace('"wall_s": 0.2', '"wall": 0.3'), {"names": {"wall_s": "wall"}}), [])

    def test_moved_key(self):
        moved = {"pointers": {"/filters/*/reference": "/filters/*/errors/all"}}
        new = SUMMARY.replace('"reference": {', '"errors": { "all": {').replace('"unit": "m" } }', '"unit": "m" } } }')
        self.assertEqual(self.summaries(new, moved), [])
        self.assertEqual(len(self.summaries(new)), 6)

    def test_part_of_a_name(self):
        renames = {"parts": {"p50": "median"}}
        old, new = '{ "ins/position.north/p50": 1.5 }', '{ "ins/position.north/median": 1.5 }'
        self.assertEqual(self.summaries(new, renames, old), [])

    def test_two_names_become_one(self):
        self.assertEqual(len(self.summaries('{ "b": 1 }', {"names": {"a": "b"}}, '{ "a": 1, "b": 1 }')), 1)

    def test_for_some_configs_only(self):
        renames = Renames({"only": [{"config": "land/*", "names": {"a": "b"}}]})
        self.assertEqual(renames.of_config("land/base.json").name("a"), "b")
        self.assertEqual(renames.of_config("drives/base.json").name("a"), "a")


class Tables(Folders):
    def tables(self, new, renames=None, old=TABLE):
        return self.places({"out/ins.csv": old}, {"out/ins.csv": new}, renames)

    def test_same(self):
        result = self.compared({"ins.csv": TABLE}, {"ins.csv": TABLE})
        self.assertEqual((result.differences, result.values), ([], 4))

    def test_last_digit(self):
        self.assertEqual(self.tables(TABLE.replace("1.5e-3", "1.5000000000000001e-3")), [])  # the same double
        self.assertEqual(self.tables(TABLE.replace("1.5e-3", "1.5000000000000003e-3")), ["out/ins.csv#position.lat.sigma[rad]"])

    def test_renamed_column(self):
        new = TABLE.replace("sigma", "std")
        self.assertEqual(len(self.tables(new)), 2)
        self.assertEqual(self.tables(new, {"parts": {"sigma": "std"}}), [])

    def test_other_order_of_columns(self):
        self.assertEqual(self.tables("position.lat.sigma[rad],t[s]\n1.5e-3,0.1\n0.1,0.2\n"), [])

    def test_row_less(self):
        self.assertEqual(self.tables(TABLE.rsplit("\n", 2)[0] + "\n"), ["out/ins.csv#rows"])

    def test_row_more(self):
        self.assertEqual(self.tables(TABLE + "0.3,1\n"), ["out/ins.csv#rows"])

    def test_renamed_cell(self):
        old, new = "variant,metric,value\nbase,a/b/p50,1\n", "variant,metric,value\nbase,a/b/median,1\n"
        self.assertEqual(len(self.tables(new, None, old)), 1)
        self.assertEqual(self.tables(new, {"parts": {"p50": "median"}}, old), [])

    def test_renamed_file(self):
        self.assertEqual(self.places({"study.csv": TABLE}, {"runs.csv": TABLE}, {"files": {"study.csv": "runs.csv"}}), [])

    def test_missing_file(self):
        self.assertEqual(self.places({"a.csv": TABLE, "b.csv": TABLE}, {"a.csv": TABLE}), ["b.csv#"])


class Differences(unittest.TestCase):
    entry = {"config": "land/*", "place": "summary.json#/filters/*/steps", "reason": "a defect", "at_most": 1e-3}
    difference = figures.Difference("summary.json#/filters/ins/steps", "1000", "1001", 1e-3)

    def test_explained(self):
        allowed = Allowed([self.entry])
        allowed.judge("land/base.json", "run")
        self.assertTrue(allowed.explains("land/base.json", "run", self.difference))
        self.assertEqual(allowed.idle(), [])

    def test_place_as_printed(self):
        column = figures.Difference("ins.csv#position.lat[rad]", "1", "2", 0.5)
        entry = {"config": "land/*", "place": column.place, "reason": "a defect"}
        self.assertTrue(Allowed([entry]).explains("land/base.json", "run", column))
        self.assertFalse(Allowed([{**entry, "place": "ins.csv#position"}]).explains("land/base.json", "run", column))

    def test_others_are_not(self):
        allowed = Allowed([self.entry])
        self.assertFalse(allowed.explains("drives/base.json", "run", self.difference))
        self.assertFalse(allowed.explains("land/base.json", "run", figures.Difference("summary.json#/filters/ins/n", "1", "2", 0.5)))

    def test_larger_is_not(self):
        larger = figures.Difference(self.difference.place, "1000", "1002", 2e-3)
        self.assertFalse(Allowed([self.entry]).explains("land/base.json", "run", larger))

    def test_that_no_longer_occurs(self):
        allowed = Allowed([self.entry])
        self.assertEqual((allowed.idle(), allowed.unjudged()), ([], [self.entry]))
        allowed.judge("land/base.json", "run")
        self.assertEqual((allowed.idle(), allowed.unjudged()), ([self.entry], []))

    def test_reason_is_needed(self):
        for entry in ({**self.entry, "reason": " "}, {"config": "*", "place": "*"}, {**self.entry, "extra": 1}):
            with self.assertRaises(Bad):
                Allowed([entry])


class Whole(unittest.TestCase):
    """The command itself, on two trees whose binnacle is a script."""

    script = """#!/bin/sh
verb=$1 config=$2; shift 2
[ "$verb" = run ] || { echo "$config:1:1: error[B010] /$verb: none" >&2; exit 3; }
grep -q part "$config" && { echo "$config:1:1: error[B028]: a part" >&2; exit 3; }
while [ "$1" != --out ]; do shift; done
cp "$config" "$2/summary.json"
"""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.folder = Path(temporary.name)
        self.addCleanup(temporary.cleanup)

    def tree(self, name, configs):
        for config, text in configs.items():
            path = self.folder / name / "configs" / config
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        binary = self.folder / name / "build/release/bin/binnacle"
        binary.parent.mkdir(parents=True)
        binary.write_text(self.script)
        binary.chmod(0o755)
        return run.Tree(self.folder / name)

    def status(self, old, new, renames=None, allowed=(), is_whole=False):
        renames, allowed = Renames(renames or {}), Allowed(list(allowed))
        plan = commands.Plan({"verbs": {"run": [], "study": [], "covariance": []}, "configs": {}})
        arguments = types.SimpleNamespace(jobs=2, limit=20, keep=None, most=5)
        base = commands.Side("base", self.tree("old", old), self.folder, lambda word: word, lambda name: name)
        other = commands.Side("new", self.tree("new", new), self.folder, renames.argument, renames.config)
        comparison = run.Comparison(arguments, plan, renames, allowed, base, other, None)
        comparison.scratch = self.folder
        outcomes = dict(comparison.carry_out(base.tree.configs()))
        self.states = {config: run.state_of(outcome) for config, outcome in outcomes.items()}
        with tempfile.TemporaryFile("w") as silence:
            stdout, sys.stdout = sys.stdout, silence
            try:
                for config, outcome in outcomes.items():
                    run.print_config(config, outcome, 5)
                return run.report(outcomes, comparison, is_whole, 0)
            finally:
                sys.stdout = stdout

    def test_equal(self):
        self.assertEqual(self.status({"a.json": SUMMARY, "b/part.json": '{"part": 1}'}, {"a.json": SUMMARY, "b/part.json": '{"part": 1}'}), 0)
        self.assertEqual(self.states, {"a.json": "equal", "b/part.json": "skipped"})

    def test_differs(self):
        self.assertEqual(self.status({"a.json": SUMMARY}, {"a.json": SUMMARY.replace("49751", "49752")}), 1)

    def test_explained(self):
        entry = {"config": "a.json", "place": "*/steps", "reason": "a defect"}
        self.assertEqual(self.status({"a.json": SUMMARY}, {"a.json": SUMMARY.replace("49751", "49752")}, allowed=[entry]), 0)
        self.assertEqual(self.states, {"a.json": "explained"})

    def test_explains_nothing_any_more(self):
        entry = {"config": "a.json", "place": "*/steps", "reason": "a defect"}
        self.assertEqual(self.status({"a.json": SUMMARY}, {"a.json": SUMMARY}, allowed=[entry]), 1)

    def test_renamed_config(self):
        self.assertEqual(self.status({"a.json": SUMMARY}, {"b.json": SUMMARY}, {"configs": {"a.json": "b.json"}}), 0)

    def test_config_that_is_gone(self):
        self.assertEqual(self.status({"a.json": SUMMARY, "b.json": SUMMARY}, {"a.json": SUMMARY}), 1)

    def test_config_that_the_new_tree_refuses(self):
        self.assertEqual(self.status({"a.json": SUMMARY}, {"a.json": '{"part": 1}'}), 1)

    def test_nothing_compared(self):
        self.assertEqual(self.status({"part.json": '{"part": 1}'}, {"part.json": '{"part": 1}'}), 1)

    def test_no_number(self):
        self.assertEqual(self.status({"a.json": "{}"}, {"a.json": "{}"}), 1)

    def test_fewer_than_a_whole_comparison_needs(self):
        self.assertEqual(self.status({"a.json": SUMMARY}, {"a.json": SUMMARY}, is_whole=True), 1)

    def test_no_data(self):
        text = '{ "vars": { "where": "../../shared/data/nowhere" } }'
        self.assertEqual(self.status({"a.json": SUMMARY, "b.json": text}, {"a.json": SUMMARY, "b.json": text}), 0)
        self.assertEqual(self.states["b.json"], "skipped")


class Committed(unittest.TestCase):
    def test_tables_can_be_read(self):
        commands.Plan.read(HERE / "plan.json")
        Renames.read(HERE / "renames.json")
        Allowed.read(HERE / "differences.json")


class Data(unittest.TestCase):
    def test_folder_of_a_tarball_and_without_git(self):
        with tempfile.TemporaryDirectory() as scratch:
            root = Path(scratch).resolve() / "binnacle"
            root.mkdir()
            path = os.environ["PATH"]
            for tools in (path, ""):
                environment = {"PATH": tools, "GIT_CEILING_DIRECTORIES": scratch, "BINNACLE_DATA": ""}
                with mock.patch.object(trees, "ROOT", root), mock.patch.dict(os.environ, environment):
                    self.assertEqual(trees.data_folder(None), root.parent / "shared" / "data")


if __name__ == "__main__":
    unittest.main()
