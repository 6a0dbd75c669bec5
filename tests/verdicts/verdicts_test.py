#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a verdict does to the exit status, and settings that do not fit the sensors: they must not lose the filter."""
import json
import os
import subprocess
import sys
import unittest
from pathlib import Path

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


if __name__ == "__main__":
    unittest.main(verbosity=2)
