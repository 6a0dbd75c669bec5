# SPDX-License-Identifier: Apache-2.0
"""What came of a run, as arrays."""

from collections.abc import Mapping

import numpy as np

OUTCOMES = ("accepted", "gated", "late", "unsupported", "invalid", "withheld", "rejected")


class Series(np.ndarray):
    """Numbers over time, (n,) or (n, outputs), SI: an array that also knows .t (n,) [s], .sigma (like itself, 1-sigma;
    None where it is not known), .names and .units (a text each per output; one text where it has one dimension).

    What is computed or cut from it is a plain array.
    """

    def __new__(cls, values, t, sigma, names, units):
        series = np.asarray(values).view(cls)
        series.t, series.sigma, series.names, series.units = t, sigma, names, units
        return series

    def __array_finalize__(self, source):
        self.t = self.sigma = self.names = self.units = None

    def __array_wrap__(self, array, context=None):
        return array[()] if array.ndim == 0 else np.asarray(array)

    def __getitem__(self, key):
        return self.view(np.ndarray)[key]


class Names(Mapping):
    """Things by name, in order; a name that is not there raises KeyError that lists those that are."""

    _what = "name"

    def __init__(self, items):
        self._items = dict(items)

    def __getitem__(self, name):
        try:
            return self._items[name]
        except KeyError:
            raise KeyError(f"there is no {self._what} {name!r}; there are {', '.join(map(repr, self._items)) or 'none'}") from None

    def __iter__(self):
        return iter(self._items)

    def __len__(self):
        return len(self._items)

    def __repr__(self):
        return f"<{type(self).__name__}: {', '.join(self._items) or 'none'}>"


class Records(Names):
    """Estimates of a filter by block: ["position"], or by output: ["position.lat"]. .t (n,) [s]; .t_ns (n,) [ns], exact."""

    _what = "block"

    def __init__(self, filter):
        self.t_ns = filter["t"]
        self.t = self.t_ns * 1e-9
        columns, values = filter["columns"], filter["values"]
        half = len(columns) // 2
        blocks = {}
        for i, (name, unit) in enumerate(columns[:half]):
            block, _, output = name.partition(".")
            blocks.setdefault(block, []).append((i, output, unit))
        series = {}
        for block, outputs in blocks.items():
            first, count = outputs[0][0], len(outputs)
            names = [output for _, output, _ in outputs]
            series[block] = Series(values[:, first : first + count], self.t,
                                   values[:, half + first : half + first + count], names, [unit for _, _, unit in outputs])
        super().__init__(series)

    def __getitem__(self, name):
        block, _, output = name.partition(".")
        series = super().__getitem__(block)
        if not output:
            return series
        if output not in series.names:
            raise KeyError(f"block {block!r} has no output {output!r}; it has {', '.join(map(repr, series.names))}")
        i = series.names.index(output)
        return Series(series[:, i], self.t, series.sigma[:, i], output, series.units[i])


class Errors(Names):
    """Errors against references and withheld samples, truth - estimate, by name: ["position.horizontal"]."""

    _what = "error"

    def __init__(self, errors):
        super().__init__(
            (error["name"], Series(error["values"], error["t"], error["sigma"], error["name"], error["unit"])) for error in errors
        )


class Innovations:
    """The fate of every sample that was offered to a measurement.

    .t (n,) [s]; .outcome (n,) as text; .reason (n,) as text, "" where it was accepted; .nis (n,), NaN where it was not
    linearized; .rows (n,). Row by row through all samples: .sample (index of the sample), .group (index in .groups,
    (name, unit) each), .key (satellite, say), .residual, .sigma (root of the diagonal of H P H' + R), .noise (of R).
    """

    def __init__(self, updates):
        self.t = updates["t"]
        self.outcome = np.asarray(OUTCOMES)[updates["outcome"]] if len(self.t) else np.empty(0, "U8")
        self.reason = np.asarray(updates["reason"], dtype=str)
        self.nis, self.rows, self.groups = updates["nis"], updates["rows"], updates["groups"]
        self.group, self.key = updates["group"], updates["key"]
        self.residual, self.sigma, self.noise = updates["residual"], updates["sigma"], updates["noise"]
        self.sample = np.repeat(np.arange(len(self.t)), self.rows)

    @property
    def accepted(self):
        """Of samples, a mask."""
        return self.outcome == "accepted"

    def __repr__(self):
        return f"<Innovations: {len(self.t)} samples, {np.count_nonzero(self.accepted)} accepted>"


class FilterResult(Records):
    """Estimates of one filter as Records has them; .errors; .innovations by measurement."""

    def __init__(self, filter):
        super().__init__(filter)
        self.name = filter["name"]
        self.errors = Errors(filter["errors"])
        self.innovations = {updates["measurement"]: Innovations(updates) for updates in filter["updates"]}


class Summary(dict):
    """Figures as `binnacle run --json` prints them; str() is what it prints for people."""

    def __init__(self, figures, text):
        super().__init__(figures)
        self._text = text

    def __str__(self):
        return self._text


class RunResult(Names):
    """A run: filters by name. .summary, .verdict ("ok", "doubtful" or "lost": the worst of all), .doubts (why),
    .failures (filters that broke or never started), .warnings: lists of Diagnostic. .channels: {name: Samples} of keep=."""

    _what = "filter"

    def __init__(self, run):
        super().__init__((filter["name"], FilterResult(filter)) for filter in run["filters"])
        self.summary = Summary(run["summary"], run["text"])
        self.verdict, self.doubts = run["verdict"], run["doubts"]
        self.failures, self.warnings = run["failures"], run["warnings"]
        self.channels = {}

    @property
    def errors(self):
        """{filter: Errors}"""
        return {name: filter.errors for name, filter in self.items()}

    @property
    def innovations(self):
        """{filter: {measurement: Innovations}}"""
        return {name: filter.innovations for name, filter in self.items()}
