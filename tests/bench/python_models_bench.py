#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a measurement model costs by how it is written: `tests/bench/python_models_bench.py [SAMPLES] [ROUNDS]`. One filter of two
coordinates, its samples seen by core/linear_measurement, by a C function of the same equation (binnacle.cfunc), by Python with H, and
by Python with H by differences. The time that the filter takes, without that of its source; each round runs all four, one after the
other. The shortest of the rounds counts, which other work on the machine disturbs least; medians stand beside."""
import ctypes
import pathlib
import statistics
import subprocess
import sys
import tempfile

import binnacle as bn
import numpy as np

C_SOURCE = r"""
#include <stdint.h>
int32_t linearize(double t, const double *constants, const double *fields, const double *row_fields, int32_t rows,
                  const double *x, double *memory, double *residual, double *H, double *R) {
  for (int i = 0; i < 2; ++i) {
    residual[i] = fields[i] - x[i];
    H[i + 2 * i] = 1;
    R[i + 2 * i] = constants[0];
  }
  return 2;
}
"""


class _Seen(bn.MeasurementModel):
    spec = bn.Spec(
        summary="A point of a plane, seen directly.",
        parameters=[bn.number("sigma", "m").above(0).required().about("white noise")],
        ports=[bn.reads("x", "vector:2:m").about("the point")],
        fields=[bn.field("z0", "m").about("first coordinate"), bn.field("z1", "m").about("second coordinate")],
    )

    def __init__(self, binding):
        self.R = np.full(2, binding.parameters["sigma"] ** 2)
        self.H = {"x": np.eye(2)}
        binding.group("x", port="x")


@bn.register(name="by_python")
class ByPython(_Seen):
    def linearize(self, sample, x):
        return sample.fields("z0", "z1") - x["x"], self.H, self.R


@bn.register(name="by_differences")
class ByDifferences(_Seen):
    def linearize(self, sample, x):
        return sample.fields("z0", "z1") - x["x"], None, self.R


def register_c(folder):
    (folder / "seen.c").write_text(C_SOURCE)
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", folder / "seen.so", folder / "seen.c"], check=True)

    @bn.register(name="by_c_function")
    class ByCFunction(_Seen):
        linearize = bn.cfunc(ctypes.CDLL(str(folder / "seen.so")).linearize)

        def __init__(self, binding):
            super().__init__(binding)
            binding.constants([self.R[0]])


def composed(folder, type, sigma):
    return bn.parse({
        "binnacle": 1,
        "sources": {"seen": {"type": "csv", "path": "seen.csv", "time": {"column": "t"},
                             "columns": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}}},
        "filters": {"point": {
            "blocks": {"place": {"type": "core/vector", "size": 2, "unit": "m", "sigma": 10}},
            "process": {"walk": {"type": "core/random_walk", "blocks": {"x": "place"}, "q": 3}},
            "measurements": {"seen": {"type": type, "channel": "seen", "blocks": {"x": "place"}, "sigma": sigma}},
        }},
    }, name=folder / "bench.json")


def main(samples, rounds):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        t = np.arange(1, samples + 1) * 0.01
        seen = np.random.default_rng(1).standard_normal((samples, 2))
        np.savetxt(folder / "seen.csv", np.column_stack([t, seen]), delimiter=",", header="t,z0,z1", comments="", fmt="%.9f")
        register_c(folder)
        all = {"core/linear_measurement": [0.5], "by_c_function": 0.5, "by_python": 0.5, "by_differences": 0.5}
        compositions = {type: composed(folder, type, sigma) for type, sigma in all.items()}
        seconds = {type: [] for type in all}
        for _ in range(rounds):
            for type, composition in compositions.items():
                summary = composition.run(records=False, innovations=False).summary
                seconds[type].append(summary["filters"]["point"]["filter_s"])
    plugin = seconds["core/linear_measurement"]
    print(f"{rounds} rounds of {samples} samples")
    for type, its in seconds.items():
        print(f"{type:<26}{min(its) / samples * 1e6:8.2f} us a sample, ratio {min(its) / min(plugin):7.2f}; medians: "
              f"{statistics.median(its) / samples * 1e6:8.2f} us, ratio {statistics.median(its) / statistics.median(plugin):7.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000, int(sys.argv[2]) if len(sys.argv) > 2 else 25)
