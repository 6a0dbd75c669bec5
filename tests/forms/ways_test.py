#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Smoothing, observability and tuning with each way to update and to propagate, of an INS whose errors are small: what they find
is what they find with an EKF, but for the second order. The figures differ, so that the way has been taken."""
import json
import os
import subprocess
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
WAYS = {
    "iterated": ['/filters/ins/measurements/fix/update="iterated"'],
    "unscented": ['/filters/ins/measurements/fix/update="unscented"'],
    "propagated": ['/filters/ins/propagation="unscented"'],
    "all, ud": ['/filters/ins/measurements/fix/update="iterated"', '/filters/ins/propagation="unscented"', '/filters/ins/covariance="ud"'],
}


def binnacle(verb, config, sets, *arguments):
    words = [word for text in sets for word in ("--set", text)]
    done = subprocess.run([os.environ["BINNACLE"], verb, config, *words, "--json", *arguments], cwd=PROJECT,
                          stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"{verb} {sets}: {done.stderr}")
    return json.loads(done.stdout), done.stderr


def numbers(value, path=()):
    if isinstance(value, dict):
        return {k: v for name, inner in value.items() for k, v in numbers(inner, path + (name,)).items()}
    if isinstance(value, list):
        return {k: v for i, inner in enumerate(value) for k, v in numbers(inner, path + (i,)).items()}
    return {path: value} if isinstance(value, (int, float)) and not isinstance(value, bool) else {}


class Ways(unittest.TestCase):
    def test_smoothed_errors(self):
        def errors(sets):
            filters = binnacle("run", "configs/quickstart.json", sets, "--smooth")[0]["filters"]
            return [filters[name]["reference"]["position.horizontal"]["rms"] for name in ("ins", "ins.smoothed")]

        forward, smoothed = errors([])
        self.assertLess(smoothed, forward)
        for way, sets in WAYS.items():
            its_forward, its_smoothed = errors(sets)
            self.assertNotEqual(its_smoothed, smoothed, way)
            self.assertLess(abs(its_forward / forward - 1), 0.05, way)
            self.assertLess(abs(its_smoothed / smoothed - 1), 0.05, way)

    def test_observability(self):
        plain = numbers(binnacle("observe", "configs/quickstart.json", [])[0])
        self.assertGreater(len(plain), 20)
        for way, sets in WAYS.items():
            found = numbers(binnacle("observe", "configs/quickstart.json", sets)[0])
            self.assertEqual(set(plain), set(found), way)

    def test_tuning(self):
        def tuned(sets):
            result, notes = binnacle("tune", "tests/tune/ins.json", sets)
            return {p["name"]: (float(str(p["end"]).split()[0]), p["standard_error"]) for p in result["parameters"]}, notes

        plain, notes = tuned([])
        self.assertNotIn("approximate", notes)
        for way in ("iterated", "propagated"):
            found, notes = tuned(WAYS[way])
            self.assertIn("approximate", notes, way)
            for name, (value, error) in plain.items():  # standard errors are relative here
                self.assertLess(abs(found[name][0] / value - 1), 0.5 * error, f"{way}: {name}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
