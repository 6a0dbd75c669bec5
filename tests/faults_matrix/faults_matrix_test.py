# SPDX-License-Identifier: Apache-2.0
"""What is judged wrong, noticed, recovered and silent, on made errors; no filter runs here (tests/faults_matrix/run does)."""
import math
import sys
import unittest
from array import array
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

import cells  # noqa: E402
import judge  # noqa: E402
import netcdf  # noqa: E402
import table  # noqa: E402

END = 300


def run(horizontal=lambda t: 0.5, attitude=lambda t: 0.2, state="ok", reasons=(), start=5.8, after=60):
    span = range(math.ceil(start), END)
    return judge.Run({t: horizontal(t) for t in span}, {t: attitude(t) for t in span}, state, list(reasons), start, after)


def config(*faults):
    return {"transforms": {"imu": {"type": "rotate_axes"}, "bad": {"type": "faults", "faults": list(faults)}}}


STEP = {"kind": "step", "from": "120 s", "until": "150 s"}
CLEAN = run()  # wrong beyond 2.5 m or 1.6 deg


class Wrong(unittest.TestCase):
    def wrong(self, **errors):
        return judge.is_wrong(run(**errors), CLEAN)

    def test_the_clean_run_is_not(self):
        self.assertEqual(judge.limits(CLEAN), (2.5, 3 * 0.2 + 1))
        self.assertFalse(judge.is_wrong(CLEAN, CLEAN))

    def test_ten_seconds_count_and_not_one(self):
        self.assertTrue(self.wrong(horizontal=lambda t: 2.6 if 120 <= t < 130 else 0.5))
        self.assertFalse(self.wrong(horizontal=lambda t: 2.6 if t == 120 else 0.5))
        self.assertFalse(self.wrong(horizontal=lambda t: 2.4))

    def test_attitude_counts_at_once(self):
        self.assertTrue(self.wrong(attitude=lambda t: 1.7 if t == 120 else 0.2))

    def test_before_the_scored_span_nothing_counts(self):
        self.assertFalse(self.wrong(horizontal=lambda t: 90 if t < 60 else 0.5, attitude=lambda t: 90 if t < 60 else 0.2))

    def test_no_number_and_no_estimate_are_wrong(self):
        self.assertEqual(judge.by_second([7.2, 7.6], [1.0, math.nan]), {7: math.inf})
        self.assertTrue(self.wrong(horizontal=lambda t: math.inf))
        self.assertTrue(judge.is_wrong(judge.Run({}, {}, "lost", [], None, 60), CLEAN))

    def test_seconds_are_root_mean_squares(self):
        self.assertEqual(judge.by_second([1.0, 1.5, 2.0], [1.0, 7.0, 3.0]), {1: 5.0, 2: 3.0})


class Faults(unittest.TestCase):
    def test_kinds(self):
        self.assertEqual(judge.fault_of("a", config(STEP), 5.8), (judge.WHILE, 120, 150))
        self.assertEqual(judge.fault_of("a", config({"kind": "swap"}), 5.8), (judge.ALONG, 5.8, None))
        self.assertEqual(judge.fault_of("mount yaw 5 deg", config(), 5.8), (judge.ALONG, 5.8, None))
        self.assertEqual(judge.fault_of("heading at the start 15 deg", config({"kind": "step"}), 5.8), (judge.WHILE, 5.8, 5.8))
        self.assertEqual(judge.fault_of("a", config(STEP, {"kind": "drop", "from": 2, "until": "3 min"}), 5.8), (judge.WHILE, 2, 180))

    def test_what_is_not_judged(self):
        for faults in ([STEP, {"kind": "swap"}], [dict(STEP, since="start")], [dict(STEP, until="150 m")]):
            self.assertRaises(judge.Bad, judge.fault_of, "a", config(*faults), 5.8)


class Noticed(unittest.TestCase):
    def noticed(self, *reasons, clean=CLEAN):
        return judge.noticed(run(reasons=reasons), clean, 120)

    def test_the_earliest(self):
        late, early = {"code": "B100", "since_s": 140.0}, {"code": "B104", "since_s": 123.5}
        self.assertEqual(self.noticed(late, early), 3.5)
        self.assertEqual(self.noticed({"code": "B104", "since_s": 110.0}), 0)
        self.assertIsNone(self.noticed({"code": "B106"}))
        self.assertIsNone(self.noticed())

    def test_what_the_clean_run_has_too_is_none_of_the_fault(self):
        known = {"code": "B105", "measurement": "fix", "part": "position", "rows": [0], "since_s": 80.0}
        clean = run(reasons=[known])
        self.assertIsNone(self.noticed(dict(known, since_s=125.0), clean=clean))
        self.assertEqual(self.noticed(dict(known, rows=[1], since_s=125.0), clean=clean), 5)


class Recovered(unittest.TestCase):
    def recovered(self, **errors):
        return judge.recovered(run(**errors), CLEAN, 150)

    def test_back_and_stays_back(self):
        self.assertEqual(self.recovered(horizontal=lambda t: 9 if t < 165 else 1.4), 15)
        self.assertEqual(self.recovered(horizontal=lambda t: 9 if t < 165 or 200 <= t < 202 else 1.4), 52)
        self.assertEqual(self.recovered(), 0)
        self.assertIsNone(self.recovered(horizontal=lambda t: 1.6))

    def test_attitude_has_to_come_back_too(self):
        self.assertEqual(self.recovered(attitude=lambda t: 1 if t < 160 else 0.8), 10)

    def test_no_estimate_is_not_back(self):
        self.assertIsNone(judge.recovered(judge.Run({}, {}, "lost", [], None, 60), CLEAN, 150))

    def test_between_seconds(self):
        self.assertEqual(judge.recovered(run(), CLEAN, 120.5), 0)
        self.assertEqual(judge.recovered(run(horizontal=lambda t: 9 if t < 122 else 0.5), CLEAN, 120.5), 1.5)


class Tables(unittest.TestCase):
    def cell(self, name="step", faults=(STEP,), **what):
        return judge.Cell(name, run(**what), CLEAN, config(*faults))

    def test_silent(self):
        bad = {"horizontal": lambda t: 9}
        self.assertTrue(self.cell(**bad).is_silent)
        self.assertFalse(self.cell(**bad, state="doubtful").is_silent)
        self.assertFalse(self.cell().is_silent)

    def test_totals(self):
        of_study = [self.cell("drift", horizontal=lambda t: 9), self.cell("hole"), self.cell("mount", (), state="lost"), self.cell("clock", ())]
        sentences = list(table.totals(of_study, {"drift": "why"}))
        self.assertIn("4 cells; 1 wrong, 1 of them with the verdict `ok`: drift; 1 of these named as unseeable", sentences[0])
        self.assertIn("1 of 2 reported; not reported: clock (not wrong).", sentences[1])
        self.assertIn("1 of 2 (50 %", sentences[2])
        self.assertIn("the others: drift (ok).", sentences[2])

    def test_row(self):
        reasons = [{"code": "B104", "measurement": "fix", "part": "velocity", "rows": [row], "since_s": 123.0} for row in (0, 1)]
        row = table.row(self.cell(horizontal=lambda t: 123 if 120 <= t < 155 else 0.5, state="doubtful", reasons=reasons))
        self.assertEqual(row, ["step", "123", "0.20", "**wrong**", "doubtful", "B104 fix.velocity", "3.0", "5.0"])
        self.assertEqual(len(table.row(self.cell("mount", ()))), len(table.HEAD))

    def test_markers(self):
        page = "a\n<!-- x: begin -->\nold\n<!-- x: end -->\nb\n"
        self.assertEqual(table.replaced(page, "x", ["new"]), "a\n<!-- x: begin -->\nnew\n<!-- x: end -->\nb\n")
        self.assertRaises(judge.Bad, table.replaced, page, "y", ["new"])

    def test_the_page_has_the_markers_of_all_studies(self):
        page = (cells.ROOT / "configs/faults/README.md").read_text(encoding="utf-8")
        for study in cells.STUDIES:
            table.replaced(page, study, [])


def variable(values, shape):
    return netcdf.Variable(6, shape, bytearray(array("d", values).tobytes()), "")


class Records(unittest.TestCase):
    def test_errors_and_their_times(self):
        errors = {"time": variable([1, 2], (2,)), "time_attitude_north": variable([3, 4], (2,)), "position_horizontal": variable([5, 6], (2,)),
                  "attitude": variable([0, 3, 4, math.nan, 0, 0], (2, 3))}
        errors = {("ins", "errors", name): content for name, content in errors.items()}
        self.assertEqual(cells.by_second(errors, "ins", "position_horizontal", "position", 1.0), {1: 5.0, 2: 6.0})
        self.assertEqual(cells.by_second(errors, "ins", "attitude", "attitude", 2.0), {3: 10.0, 4: math.inf})
        self.assertEqual(cells.by_second(errors, "ins", "velocity", "velocity", 1.0), {})

    def test_the_scored_span(self):
        self.assertEqual(cells.scored_from({"evaluate": {"after": "60 s"}}, 5.8), 60)
        self.assertEqual(cells.scored_from({"evaluate": {"after": "start+10 s"}}, 5.5), 15.5)
        self.assertEqual(cells.scored_from({}, None), 0)


if __name__ == "__main__":
    unittest.main()
