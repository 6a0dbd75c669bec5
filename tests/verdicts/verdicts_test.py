#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a verdict does to the exit status, and settings that do not fit the sensors: they must not lose the filter."""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
ANOTHER_CAR = str(Path(__file__).resolve().parent / "another_car.json")


def binnacle(*arguments):
    return subprocess.run([os.environ["BINNACLE"], *arguments], stdin=subprocess.DEVNULL, capture_output=True, text=True)


class AnotherCar(unittest.TestCase):
    def test_a_run_is_not_lost_by_noise_that_is_specified_too_small(self):
        done = binnacle("run", ANOTHER_CAR, "--json", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        figures = json.loads(done.stdout)["filters"]["ins"]
        self.assertEqual(figures["verdict"]["state"], "doubtful")
        self.assertIn("B106", done.stderr)
        self.assertIn("B103", done.stderr)
        worst = json.loads(binnacle("study", ANOTHER_CAR, "--json", "--quiet").stdout)["variants"]["as it is"]["metrics"]
        self.assertLess(next(iter(worst.values()))["max"], 5)

    def test_strict_makes_doubtful_a_failure(self):
        self.assertEqual(binnacle("run", ANOTHER_CAR, "--quiet", "--strict").returncode, 1)

    def test_without_recovery_the_run_is_lost(self):
        done = binnacle("run", ANOTHER_CAR, "--quiet", "--variant", "without recovery")
        self.assertEqual(done.returncode, 1)
        self.assertIn("B102", done.stderr)

    def test_a_study_counts_lost_runs_and_fails_only_with_strict(self):
        done = binnacle("study", ANOTHER_CAR, "--json", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        variants = json.loads(done.stdout)["variants"]
        self.assertEqual(variants["as it is"]["verdicts"], {"ok": 0, "doubtful": 2, "lost": 0})
        self.assertEqual(variants["without recovery"]["verdicts"], {"ok": 0, "doubtful": 0, "lost": 2})
        self.assertEqual(binnacle("study", ANOTHER_CAR, "--json", "--quiet", "--strict").returncode, 1)
        self.assertEqual(binnacle("study", ANOTHER_CAR, "--quiet", "--strict", "--set", "/study/variants/without recovery=null").returncode, 0)


class WithLimits(unittest.TestCase):
    """An accelerometer that is scaled by 2 %: its innovations show it, the estimates hardly."""
    CELL = ["run", str(CONFIGS / "faults/simulated.json"), "--quiet", "--variant", "accelerometer scaled 1.02"]
    LIMITS = "/filters/ins/limits="

    def recorded(self, scratch, *arguments):
        folder = str(Path(scratch) / "out")
        done = binnacle(*self.CELL, "--out", folder, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads((Path(folder) / "summary.json").read_text(encoding="utf-8"))
        return folder, done, summary["filters"]["ins"]["verdict"]

    def test_without_limits_three_sigma_count_and_a_recorded_run_is_judged_again(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder, done, verdict = self.recorded(scratch, "--set", self.LIMITS + "null")
            self.assertEqual((verdict["state"], verdict["limits"]), ("doubtful", {}))
            self.assertIn("B105", done.stderr)
            shown = binnacle("verdict", folder)
            self.assertEqual(shown.returncode, 0, shown.stderr)
            self.assertIn("ins: doubtful\n  limit of each estimate: 3 sigma\n  reason B105: ", shown.stdout)
            self.assertRegex(shown.stdout, r"would go unseen: a bias of 'fix' position \d of up to 0\.\d+ m for 30\.00 s; it moves position")
            self.assertEqual(binnacle("verdict", folder, "--strict").returncode, 1)
            again = binnacle("verdict", folder, "--limit", "position=2m", "--limit", "velocity=0.5 m/s", "--limit", "attitude=2 deg", "--strict")
            self.assertEqual(again.returncode, 0, again.stdout)
            self.assertIn("ins: ok (recorded as doubtful)\n", again.stdout)
            self.assertIn("  note B105: ", again.stdout)

    def test_limits_of_the_config_make_a_note_of_it_and_may_be_taken_back(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder, done, verdict = self.recorded(scratch)
            self.assertEqual((verdict["state"], done.stderr), ("ok", ""))
            self.assertEqual(verdict["limits"]["position"], 2)
            self.assertEqual([note["significant"] for note in verdict["notes"] if note["code"] == "B105"], ["doubtful"])
            self.assertIn("ins: doubtful (recorded as ok)", binnacle("verdict", folder, "--limit", "position=1cm").stdout)

    def test_an_effect_that_is_no_number_is_not_small(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder, _, _ = self.recorded(scratch)
            file = Path(folder) / "summary.json"
            summary = json.loads(file.read_text(encoding="utf-8"))
            for note in summary["filters"]["ins"]["verdict"]["notes"]:
                for effect in note.get("effects", {}).values():
                    effect.update(largest=None, of_3_sigma=None)
            file.write_text(json.dumps(summary), encoding="utf-8")
            self.assertIn("ins: doubtful (recorded as ok)", binnacle("verdict", folder, "--limit", "position=100 m").stdout)

    def test_limits_never_hide_what_moves_another_estimate(self):
        cell = [*self.CELL[:-1], "mount yaw 5 deg"]
        done = binnacle(*cell, "--json", "--set", self.LIMITS + '{"position": "10 m", "attitude": "10 deg", "velocity": 10}')
        self.assertEqual(json.loads(done.stdout)["filters"]["ins"]["verdict"]["state"], "doubtful")

    def test_a_recovery_that_moves_the_position_by_more_than_ten_limits_is_lost(self):
        late = '/transforms/bad_gnss/faults=[{"kind": "delay", "time": "3 s", "from": "160 s", "until": "200 s"}]'
        with tempfile.TemporaryDirectory() as scratch:
            folder = str(Path(scratch) / "out")
            done = binnacle("run", self.CELL[1], "--quiet", "--out", folder, "--set", late)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, r"B106.* times, first at 1[67]\d\.\d s: .*; it moved 'position' by [2-9]\d\.?\d* m")
            for limit, said in (("position=10 m", "ins: doubtful (recorded as lost)"), ("velocity=0.1 m/s", "ins: doubtful (recorded as lost)"),
                                ("position=2 m", "ins: lost")):
                shown = binnacle("verdict", folder, "--limit", limit)
                self.assertEqual(shown.stdout.splitlines()[0], said, limit)
                self.assertEqual(shown.returncode, int(said == "ins: lost"))

    def test_wrong_limits_are_named(self):
        for text, message in (('{"positon": 2}', "there is no block 'positon'; did you mean 'position'?"),
                              ('{"position": "2 deg"}', "'2 deg' is an angle; 'position' is a length"), ("3", "'limits'")):
            done = binnacle(*self.CELL, "--set", self.LIMITS + text)
            self.assertEqual(done.returncode, 3)
            self.assertIn(message, done.stderr)
        done = binnacle("check", str(CONFIGS / "gallery/tight-ins-gnss.json"), "--set", '/filters/ins/limits={"clock": "10 m"}')
        self.assertIn("the components of 'clock' have no unit in common", done.stderr)
        with tempfile.TemporaryDirectory() as scratch:
            folder, _, _ = self.recorded(scratch)
            for limit, message in (("positon=2m", "no filter of"), ("position", "BLOCK=QUANTITY"), ("position=2deg", "in m; found '2deg'")):
                done = binnacle("verdict", folder, "--limit", limit)
                self.assertEqual(done.returncode, 2)
                self.assertIn(message, done.stderr)
            self.assertEqual(binnacle("verdict", scratch).returncode, 5)


if __name__ == "__main__":
    unittest.main(verbosity=2)
