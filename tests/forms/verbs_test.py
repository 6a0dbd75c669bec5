#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What works on a filter's records sees no difference between the forms: errors, NEES, smoothing, observability."""
import json
import os
import subprocess
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
CONFIG = "configs/quickstart.json"
FORMS = ("ud", "square_root")
TIMES = {"wall_s", "filter_s"}  # of the machine


def binnacle(form, verb, *arguments):
    done = subprocess.run([os.environ["BINNACLE"], verb, CONFIG, "--set", f'/filters/ins/covariance="{form}"', *arguments],
                          cwd=PROJECT, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"{verb}: {done.stderr}")
    return done.stdout


def figures(value, path=()):
    """{path: number} of all numbers in JSON but those of the machine's time."""
    if isinstance(value, dict):
        return {k: v for name, inner in value.items() if name not in TIMES
                for k, v in figures(inner, path + (name,)).items()}
    if isinstance(value, list):
        return {k: v for i, inner in enumerate(value) for k, v in figures(inner, path + (i,)).items()}
    return {path: value} if isinstance(value, (int, float)) and not isinstance(value, bool) else {}


class Verbs(unittest.TestCase):
    def compare(self, verb, *arguments, least=50, within=1e-7):
        joseph = figures(json.loads(binnacle("joseph", verb, *arguments, "--json")))
        self.assertGreater(len(joseph), least)
        for form in FORMS:
            other = figures(json.loads(binnacle(form, verb, *arguments, "--json")))
            self.assertEqual(set(joseph), set(other), form)
            for path, value in joseph.items():
                self.assertLessEqual(abs(other[path] - value), within * max(abs(value), 1e-3), f"{form}: {path}")

    def test_a_run_and_its_smoothed_filter(self):
        self.compare("run", "--smooth")

    def test_observability(self):
        self.compare("observe", least=20)


if __name__ == "__main__":
    unittest.main(verbosity=2)
