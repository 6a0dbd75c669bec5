# SPDX-License-Identifier: Apache-2.0
"""What differs between the results of two runs that should agree but for rounding."""
import array
import math

from netcdf import FORMATS

LIMIT = 1e-6  # of sigma


class Difference:
    """The largest differences between two runs; estimates in sigma, sigmas relative, samples by number."""

    def __init__(self):
        self.estimates = self.sigmas = 0.0
        self.samples = 0  # whose outcome or number of rows is another
        self.compared = 0
        self.where = {"estimates": "", "sigmas": "", "samples": ""}
        self.texts = []

    def say(self, text):
        self.texts.append(text)

    def note(self, what, value, where):
        if value > getattr(self, what) or math.isnan(value):
            setattr(self, what, math.inf if math.isnan(value) else value)
            self.where[what] = where

    def beyond(self, most):
        """Texts of what is more than the most that it may be."""
        texts = list(self.texts)
        for what in ("estimates", "sigmas", "samples"):
            if not getattr(self, what) <= most[what]:
                texts.append(f"{what} differ by {getattr(self, what):.2g} (at most {most[what]:.2g}), {self.where[what]}")
        return texts

    def __str__(self):
        texts = [f"estimates {self.estimates:.1e}, sigmas {self.sigmas:.1e}, {self.samples} of {self.compared} samples"]
        return ", ".join(texts + self.texts)


def numbers(variable):
    return array.array(FORMATS[variable.kind], bytes(variable.data))


def compare_estimates(one, other, path, found):
    """A value and its sigma, `path` and `path`_sigma."""
    sigma_path = path[:-1] + (path[-1] + "_sigma",)
    a, b = numbers(one[path]), numbers(other[path])
    sigma_a, sigma_b = numbers(one[sigma_path]), numbers(other[sigma_path])
    name = "/".join(path)
    if len(a) != len(b):
        return found.say(f"{name} has {len(b)} values instead of {len(a)}")
    angle = one[path].units == "rad"
    for i, (x, y, s, t) in enumerate(zip(a, b, sigma_a, sigma_b)):
        if math.isnan(x) != math.isnan(y) or math.isnan(s) != math.isnan(t):
            found.say(f"{name}[{i}] is a number in one only")
            return None
        if math.isnan(x) or math.isnan(s):
            continue
        off = abs(y - x)
        if angle:
            off = min(off, abs(off - 2 * math.pi))
        # What is known exactly may be off by rounding.
        rounding = 1e-12 * max(1.0, abs(x))
        if s > 0:
            found.note("sigmas", abs(t - s) / s, f"{name}[{i}]")
        if off > rounding:
            found.note("estimates", off / s if s > 0 else math.inf, f"{name}[{i}]")
    return None


def compare_samples(one, other, path, found):
    """The outcome of each sample, and how many of its rows were used."""
    for what in ("outcome", "rows"):
        its = path[:-1] + (what,)
        if its not in one:
            continue
        a, b = numbers(one[its]), numbers(other[its]) if its in other else []
        if len(a) != len(b):
            return found.say(f"{'/'.join(its)} has {len(b)} samples instead of {len(a)}")
        if what == "outcome":
            found.compared += len(a)
        different = [i for i in range(len(a)) if a[i] != b[i]]
        if different:
            found.note("samples", max(found.samples, len(different)) if what == "rows" else found.samples + len(different),
                       f"{'/'.join(its)}[{different[0]}]")
    return None


def compared(one, other, filters):
    """Of two files, {path: Variable}."""
    found = Difference()
    if set(one) != set(other):
        found.say(f"{sorted(set(one) ^ set(other))[0]} is in one only")
        return found
    for path in sorted(one):
        if path[0] not in filters:
            continue
        if path[-1] == "outcome" and "measurements" in path:
            compare_samples(one, other, path, found)
        elif len(path) == 2 and path[:-1] + (path[-1] + "_sigma",) in one:
            compare_estimates(one, other, path, found)
    return found
