#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The comparison of forms finds what it must: an estimate, a sigma, an outcome, and a row that are not the same."""
import array
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent / "compare"))

from difference import LIMIT, compared  # noqa: E402
from netcdf import Variable  # noqa: E402

MOST = {"estimates": LIMIT, "sigmas": LIMIT, "samples": 0}


def doubles(values, units="m"):
    return Variable(6, (len(values),), bytearray(array.array("d", values).tobytes()), units)


def run(x=2.0, sigma=0.1, outcome=0, rows=3, units="m"):
    return {
        ("f", "x"): doubles([1.0, x], units),
        ("f", "x_sigma"): doubles([0.1, sigma], units),
        ("f", "measurements", "fix", "outcome"): Variable(1, (2,), bytearray([0, outcome]), ""),
        ("f", "measurements", "fix", "rows"): Variable(4, (2,), bytearray(array.array("i", [3, rows]).tobytes()), ""),
    }


def complaints(other):
    return compared(run(), other, ["f"]).beyond(MOST)


class Found(unittest.TestCase):
    def test_equal_runs_and_rounding_pass(self):
        self.assertEqual(complaints(run()), [])
        self.assertEqual(complaints(run(x=2.0 + 0.9e-7, sigma=0.1 * (1 + 0.9e-6))), [])
        self.assertEqual(compared(run(), run(), ["f"]).compared, 2)

    def test_what_is_not_the_same_is_named(self):
        self.assertIn("estimates differ by 1.1e-06", complaints(run(x=2.0 + 1.1e-7))[0])
        self.assertIn("sigmas differ by 1.1e-06", complaints(run(sigma=0.1 * (1 + 1.1e-6)))[0])
        self.assertIn("samples differ by 1 (at most 0), f/measurements/fix/outcome[1]", complaints(run(outcome=1))[0])
        self.assertIn("f/measurements/fix/rows[1]", complaints(run(rows=2))[0])
        self.assertIn("number in one only", complaints(run(x=float("nan")))[0])
        other = run()
        del other[("f", "x")]
        self.assertIn("is in one only", complaints(other)[0])

    def test_an_angle_that_comes_round_is_the_same(self):
        one, other = run(x=-3.14159265358979, units="rad"), run(x=3.14159265358979, units="rad")
        self.assertEqual(compared(one, other, ["f"]).beyond(MOST), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
