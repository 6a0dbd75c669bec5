# SPDX-License-Identifier: Apache-2.0
"""What came of a run, as arrays."""

import copy
import json
import os
import re
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

from . import _core, _frames
from ._core import outcomes as OUTCOMES
from ._errors import DataError, Diagnostic
from ._log import StepLog

_Thing = TypeVar("_Thing")


class Series(np.ndarray):
    """Numbers over time, (n,) or (n, outputs), SI: an array that also knows .t (n,) [s], .sigma (like itself, 1-sigma;
    None where it is not known), .names, .units and .display_units (a text each per output; one text where it has one
    dimension). display_units are what tables show; the numbers are SI.

    What is computed or cut from it is a plain array; copies, and what pickle restores, are whole.
    """

    t: np.ndarray
    sigma: np.ndarray | None
    names: Any  # list[str], or str of one output
    units: Any
    display_units: Any

    def __new__(cls, values, t, sigma, names, units, display_units=None):
        series = np.asarray(values).view(cls)
        series.t, series.sigma, series.names, series.units = t, sigma, names, units
        series.display_units = units if display_units is None else display_units
        return series

    def __array_finalize__(self, source):
        self.t = self.sigma = self.names = self.units = self.display_units = None

    def copy(self, order="C"):
        return self._rebuilt(np.array(self, order=order), *self._beside())

    def __copy__(self):
        return self.copy()

    def __deepcopy__(self, memo):
        return self._rebuilt(np.array(self), *copy.deepcopy(self._beside(), memo))

    def __reduce__(self):
        return type(self)._rebuilt, (np.asarray(self), *self._beside())

    def _beside(self):
        return self.t, self.sigma, self.names, self.units, self.display_units

    @classmethod
    def _rebuilt(cls, values, t, sigma, names, units, display_units):
        return cls(values, t, sigma, names, units, display_units)

    def __array_wrap__(self, array, context=None):
        return array[()] if array.ndim == 0 else np.asarray(array)

    def __getitem__(self, key):
        return self.view(np.ndarray)[key]


class Names(Mapping[str, _Thing]):
    """Things by name, in order; a name that is not there raises KeyError that lists those that are."""

    _what = "name"

    def __init__(self, items):
        self._items = dict(items)

    def __getitem__(self, name: str) -> _Thing:
        try:
            return self._items[name]
        except KeyError:
            known = ", ".join(map(repr, self._items)) or "none"
            raise KeyError(f"there is no {self._what} {name!r}; there are {known}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self):
        return f"<{type(self).__name__}: {', '.join(self._items) or 'none'}>"


class Records(Names[Series]):
    """Estimates of a filter by block: ["position"], or by output: ["position.lat"]. .t (n,) [s]; .t_ns (n,) [ns], exact
    (of results of a file: the nearest to their seconds). .others: what is recorded beside blocks, by name (adapted noise,
    implied states, local coordinates); ["match.velocity.noise"] finds it too."""

    _what = "block"
    t: np.ndarray
    t_ns: np.ndarray
    others: "Others"

    def __init__(self, filter):
        self.t, self.t_ns = filter["t"], filter["t_ns"]
        self._values, outputs, others = filter["values"], filter["outputs"], filter["others"]
        self._columns = [(f"{block}.{output}", unit) for block, output, unit, _ in outputs]
        self._columns += [(name + ".sigma", unit) for name, unit in self._columns] + list(others)
        super().__init__(self._blocks(outputs))
        self.others = Others(self._series_of_others(2 * len(outputs), others))

    def _blocks(self, outputs):
        places = {}
        for i, (block, *_) in enumerate(outputs):
            places.setdefault(block, []).append(i)
        for block, columns in places.items():
            first, end, half = columns[0], columns[-1] + 1, len(outputs)
            names, units, shown = (list(texts) for texts in zip(*(outputs[i][1:] for i in columns)))
            sigma = self._values[:, half + first : half + end]
            yield block, Series(self._values[:, first:end], self.t, sigma, names, units, shown)

    def _series_of_others(self, first, others):
        columns = {name: first + i for i, (name, _) in enumerate(others)}
        for name, unit in others:
            if name.endswith(".sigma") and name[: -len(".sigma")] in columns:
                continue
            sigma = columns.get(name + ".sigma")
            sigma = None if sigma is None else self._values[:, sigma]
            yield name, Series(self._values[:, columns[name]], self.t, sigma, name, unit)

    def __getitem__(self, name: str) -> Series:
        if name in self.others:
            return self.others[name]
        block, _, output = name.partition(".")
        series = super().__getitem__(block)
        if not output:
            return series
        if output not in series.names:
            raise KeyError(f"block {block!r} has no output {output!r}; it has {', '.join(map(repr, series.names))}")
        i, sigma = series.names.index(output), np.asarray(series.sigma)
        return Series(series[:, i], self.t, sigma[:, i], output, series.units[i], series.display_units[i])

    def to_pandas(self):
        """A DataFrame with the columns of FILTER.csv ("position.lat", …, "position.lat.sigma", …) over t [s]; units in .attrs.

        The numbers are not copied where pandas does not.
        """
        return _frames.records_frame(self.t, self._values, self._columns)


class Others(Names[Series]):
    _what = "other column"


class Errors(Names[Series]):
    """Errors against references and withheld samples, truth - estimate, by name: ["position.horizontal"]."""

    _what = "error"

    def __init__(self, errors):
        super().__init__((error["name"], _error_series(error)) for error in errors)
        self.components = {error["name"] for error in errors if error["is_component"]}  # of a block's error: no norm, no NEES

    def to_pandas(self):
        """{name: DataFrame with "error" and, where it is known, "sigma" over t [s]}: references come at times of their own."""
        return {name: _frames.error_frame(name, series) for name, series in self.items()}


def _error_series(error):
    return Series(error["values"], error["t"], error["sigma"], error["name"], error["unit"], error["display_unit"])


class Innovations:
    """The fate of every sample that was offered to a measurement.

    .t (n,) [s]; .outcome (n,) as text, .outcome_code (n,) as index in .outcomes; .reason (n,) as text, "" where it was
    accepted; .nis (n,), NaN where it was not linearized; .rows (n,). Row by row through all samples: .sample (index of the
    sample), .group (index in .groups, (name, unit) each), .key (satellite, say), .residual, .sigma (root of the diagonal of H
    P H' + R), .noise (of R).
    """

    name: str
    t: np.ndarray
    outcome: np.ndarray
    outcome_code: np.ndarray
    reason: np.ndarray
    nis: np.ndarray
    rows: np.ndarray
    groups: list[tuple[str, str]]
    sample: np.ndarray
    group: np.ndarray
    key: np.ndarray
    residual: np.ndarray
    sigma: np.ndarray
    noise: np.ndarray

    def __init__(self, updates):
        self.name = updates["measurement"]
        self.t = updates["t"]
        self.outcome_code = updates["outcome"]
        self.outcome = np.asarray(OUTCOMES)[self.outcome_code]
        self._reasons, self._reason = updates["reasons"], updates["reason"]
        self.reason = np.asarray(self._reasons or [""], dtype=str)[self._reason]
        self.nis, self.rows, self.groups = updates["nis"], updates["rows"], updates["groups"]
        self.group, self.key = updates["group"], updates["key"]
        self.residual, self.sigma, self.noise = updates["residual"], updates["sigma"], updates["noise"]
        self.sample = np.repeat(np.arange(len(self.t)), self.rows)

    @property
    def accepted(self) -> np.ndarray:
        """Of samples, a mask."""
        return self.outcome == "accepted"

    outcomes = OUTCOMES

    def reason_texts(self):
        """(texts, index of each sample's reason in them), "" first, as run.nc has them."""
        texts = [""] + [text for text in self._reasons if text]
        places = np.asarray([texts.index(text) for text in self._reasons], dtype=np.int32)
        return texts, places[self._reason] if len(places) else self._reason

    def __repr__(self):
        return f"<Innovations: {len(self.t)} samples, {np.count_nonzero(self.accepted)} accepted>"

    def to_pandas(self):
        """Two DataFrames, (samples, rows): outcome, reason, nis and rows over t [s]; and row by row sample, t, group, key,
        residual, sigma and noise, in the unit of the group."""
        return _frames.innovation_frames(self)


class FilterResult(Records):
    """Estimates of one filter as Records has them; .errors; .innovations by measurement; .log, a StepLog where the run
    kept one."""

    name: str
    errors: Errors
    innovations: dict[str, Innovations]
    log: StepLog | None

    def __init__(self, filter):
        super().__init__(filter)
        self.name = filter["name"]
        self.errors = Errors(filter["errors"])
        self.innovations = {updates["measurement"]: Innovations(updates) for updates in filter["updates"]}
        log = filter.get("log")
        self.log = None if log is None else StepLog(log)

    def to_xarray(self):
        """{group: xarray.Dataset} as run.nc has them: "" the estimates, "errors", "measurements/NAME"."""
        return _frames.filter_datasets(self)


class Figures(dict[str, Any]):
    """Figures as the command prints them with --json; str() is what it prints for people."""

    def __init__(self, figures, text):
        super().__init__(figures)
        self._text = text

    def __str__(self):
        return self._text

    def _repr_pretty_(self, printer, cycle):
        printer.text(str(self))


class RunResult(Names[FilterResult]):
    """A run: filters by name. .summary, .verdict ("ok", "doubtful" or "lost": the worst of all), .doubts (why),
    .failures (filters that broke or never started), .warnings: lists of Diagnostic. .config: as it was run. .provenance: where
    results of a folder come from (version, command, seed, plugins); None of a run. .channels: {name: Samples} of keep=."""

    _what = "filter"
    summary: Figures
    verdict: str
    doubts: list[Diagnostic]
    failures: list[Diagnostic]
    warnings: list[Diagnostic]
    channels: dict[str, Any]  # of Samples
    config: dict[str, Any] | None
    provenance: dict[str, Any] | None

    def __init__(self, run, config=None):
        super().__init__((filter["name"], FilterResult(filter)) for filter in run["filters"])
        self.summary = Figures(run["summary"], run["text"])
        self.verdict, self.doubts = run["verdict"], run["doubts"]
        self.failures, self.warnings = run["failures"], run["warnings"]
        self.channels = {}
        self.config, self.provenance = config, run.get("provenance")

    def __repr__(self):
        filters = ", ".join(f"{name} ({len(filter.t)} estimates)" for name, filter in self.items())
        return f"<RunResult {self.verdict}: {filters or 'no filter'}>"

    def _repr_pretty_(self, printer, cycle):
        printer.text(str(self.summary))

    @property
    def errors(self) -> dict[str, Errors]:
        """{filter: Errors}"""
        return {name: filter.errors for name, filter in self.items()}

    @property
    def innovations(self) -> dict[str, dict[str, Innovations]]:
        """{filter: {measurement: Innovations}}"""
        return {name: filter.innovations for name, filter in self.items()}

    def to_pandas(self):
        """{filter: DataFrame of its estimates}; errors and innovations have a to_pandas() of their own. ImportError without
        pandas."""
        return {name: filter.to_pandas() for name, filter in self.items()}

    def to_xarray(self):
        """{group: xarray.Dataset}, the groups, variables, units and coordinates of run.nc: "ins", "ins/errors",
        "ins/measurements/fix". ImportError without xarray."""
        datasets = {}
        for name, filter in self.items():
            for group, dataset in filter.to_xarray().items():
                datasets[name + ("/" + group if group else "")] = dataset
        return datasets


class Metrics(Names[np.ndarray]):
    """Values of every run by metric, (runs,) in SI, NaN where the run broke. .units and .display_units by metric."""

    _what = "metric"
    units: dict[str, str]
    display_units: dict[str, str]

    def __init__(self, values, units, display_units):
        super().__init__(values)
        self.units, self.display_units = units, display_units


class StudyResult(Names[Metrics]):
    """A study: Metrics by variant. .summary: its figures; .tables: those of the config, as dicts; .failures: {variant: [(run,
    reason)]}; .warnings; .runs, .seed, .config."""

    _what = "variant"
    summary: Figures
    tables: list[dict[str, Any]]
    runs: int
    seed: int
    config: dict[str, Any]
    provenance: dict[str, Any]
    warnings: list[Diagnostic]

    def __init__(self, study):
        figures = study["figures"]
        metrics = {name: (i, si, shown) for i, (name, si, shown) in enumerate(study["metrics"])}
        super().__init__(
            (variant, _metrics_of(figures["variants"][variant], study["values"][v], metrics))
            for v, variant in enumerate(study["variants"])
        )
        self.summary = Figures(figures, study["text"])
        self.tables = figures.get("tables", [figures["table"]] if "table" in figures else [])
        self.runs, self.seed = study["values"].shape[2], study["provenance"]["seed"]
        self.config, self.provenance, self.warnings = study["config"], study["provenance"], study["warnings"]

    @property
    def failures(self) -> dict[str, list[tuple[int, str]]]:
        failures = {name: of.get("failures", []) for name, of in self.summary["variants"].items()}
        return {name: [(failed["run"], failed["reason"]) for failed in of] for name, of in failures.items() if of}

    def __repr__(self):
        return f"<StudyResult: {self.runs} runs, seed {self.seed}, of {', '.join(self)}>"

    def _repr_pretty_(self, printer, cycle):
        printer.text(str(self.summary))

    def to_pandas(self):
        """A DataFrame of every run: a column per metric [SI], rows by (variant, run). ImportError without pandas."""
        return _frames.study_frame(self)

    def to_xarray(self):
        """A Dataset of a variable (variant, run) per metric [SI], named as in study.nc. ImportError without xarray."""
        return _frames.study_dataset(self)


def _metrics_of(figures, values, metrics):
    own = {name: metrics[name] for name in metrics if name in figures["metrics"]}
    units = {name: si for name, (_, si, _) in own.items()}
    shown = {name: unit for name, (_, _, unit) in own.items()}
    return Metrics(((name, values[i]) for name, (i, _, _) in own.items()), units, shown)


_VERDICTS = ("ok", "doubtful", "lost")
_DIAGNOSTIC = re.compile(r"(error|warning)(?:\[(B\d+)\])?: ")


def _diagnostic(text):
    found = _DIAGNOSTIC.search(text)
    severity, code = found.groups() if found else ("warning", None)
    return Diagnostic(severity, code or "", "", 0, 0, "", text[found.end() :] if found else text, text)


def _opened_run(run):
    verdicts = [filter["verdict"]["state"] for filter in run["summary"]["filters"].values() if "verdict" in filter]
    run["verdict"] = max(verdicts, key=_VERDICTS.index, default="ok")
    run["text"] = json.dumps(run["summary"], indent=2)
    run["warnings"] = [_diagnostic(text) for text in run["summary"].get("warnings", [])]
    run["doubts"], run["failures"] = [], []
    return RunResult(run, run["config"])


def _opened_study(study):
    study["text"], study["warnings"] = json.dumps(study["figures"], indent=2), []
    return StudyResult(study)


def open(folder: str | os.PathLike[str]) -> Any:
    """What `binnacle run --out`, `binnacle study --out` or run(out=…) left in the folder: a RunResult or a StudyResult, the
    numbers to the last bit (a tuple of both where the folder has both).

    str() of their figures is JSON, and .warnings has doubts as well, as texts. Raises DataError, one line that says what is
    missing or damaged.
    """
    run, study = _core.open(str(folder))
    found = [_opened_run(run)] if run is not None else []
    found += [_opened_study(study)] if study is not None else []
    return found[0] if len(found) == 1 else tuple(found)
