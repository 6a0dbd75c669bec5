# SPDX-License-Identifier: Apache-2.0
"""Measurement models that are C functions, of ctypes and of numba, against the same in Python."""

import ctypes
import subprocess

import binnacle as bn
import numpy as np
import pytest
from test_models import _Range, run, three, world  # noqa: F401 (a fixture)

C_RANGE = r"""
#include <math.h>
#include <stdint.h>
int32_t linearize(double t, const double *constants, const double *fields, const double *row_fields, int32_t rows,
                  const double *x, double *memory, double *residual, double *H, double *R) {
  const double dx = x[0] - constants[1], dy = x[1] - constants[2], length = sqrt(dx * dx + dy * dy);
  if (length < 1e-3) return -1;
  residual[0] = fields[0] - length;
  H[0] = dx / length;
  H[1] = dy / length;
  R[0] = constants[0];
  memory[0] += 1;
  return 1;
}
"""


@pytest.fixture(scope="module")
def c_range(tmp_path_factory):
    folder = tmp_path_factory.mktemp("c")
    (folder / "range.c").write_text(C_RANGE)
    subprocess.run(["cc", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "-o", folder / "range.so", folder / "range.c", "-lm"], check=True)
    return ctypes.CDLL(str(folder / "range.so")).linearize


def fast(function, name):
    class Fast(_Range):
        linearize = bn.cfunc(function)

        def __init__(self, binding):
            super().__init__(binding)
            binding.constants([self.variance, *self.anchor])
            binding.keeps({"count": 0.0})

    return bn.register(Fast, name=name)


def test_a_c_function_gives_what_python_gives(world, c_range):
    fast(c_range, "c_range")
    python, c = run(world, three("my_range"))["point"], run(world, three("c_range"))["point"]
    assert c.innovations["r0"].accepted.all()
    np.testing.assert_allclose(c["place"], python["place"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(c["place"].sigma, python["place"].sigma, rtol=1e-12)


def test_a_numba_function_gives_what_python_gives(world):
    numba = pytest.importorskip("numba", reason="numba (Debian: python3-numba) is not installed")
    types = numba.types
    pointer = types.CPointer(types.float64)
    signature = types.int32(types.float64, pointer, pointer, pointer, types.int32, pointer, pointer, pointer, pointer, pointer)

    @numba.cfunc(signature)
    def linearize(t, constants, fields, row_fields, rows, x, memory, residual, H, R):
        dx, dy = x[0] - constants[1], x[1] - constants[2]
        length = (dx * dx + dy * dy) ** 0.5
        residual[0] = fields[0] - length
        H[0], H[1] = dx / length, dy / length
        R[0] = constants[0]
        return 1

    fast(linearize, "numba_range")
    python, c = run(world, three("my_range"))["point"], run(world, three("numba_range"))["point"]
    np.testing.assert_allclose(c["place"], python["place"], rtol=0, atol=1e-12)
