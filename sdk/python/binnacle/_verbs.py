# SPDX-License-Identifier: Apache-2.0
"""What the command does with a config besides running it: the same figures, and str() is what it prints."""

from typing import Any

from . import _core
from ._errors import Diagnostic
from ._results import Figures, RunResult, StudyResult


class Analysis(Figures):
    """Figures of a verb as the command prints them with --json; str() is what it prints for people. .warnings, .failures:
    lists of Diagnostic."""

    def __init__(self, result):
        super().__init__(result["figures"], result["text"])
        self.warnings, self.failures = result.get("warnings", []), result.get("failures", [])


class Tuning(Analysis):
    """What tune() found. .patch: a dict, the values as a merge patch that "extends" and parse() take; .converged: whether it
    ended where it should, with everything determined."""

    @property
    def patch(self) -> dict[str, Any]:
        return self["patch"]

    @property
    def converged(self) -> bool:
        return bool(self["converged"]) and not self["undetermined"]


class AllanDeviation(Analysis):
    """A channel's noise. .tau(field) (k,) [s], .deviation(field) (k,) in the field's unit; .svg: the picture, as text."""

    def __init__(self, result):
        super().__init__(result)
        self.svg = result["svg"]

    def _points(self, field, name):
        if field not in self["fields"]:
            raise KeyError(f"there is no field {field!r}; there are {', '.join(map(repr, self['fields']))}")
        import numpy

        return numpy.array([point[name] for point in self["fields"][field]["points"]], dtype=float)

    def tau(self, field):
        return self._points(field, "tau_s")

    def deviation(self, field):
        return self._points(field, "deviation")


def _count(value, name, least):
    if value is not None and (isinstance(value, bool) or int(value) != value or value < least):
        raise ValueError(f"{name} is {value!r}: expected a whole number from {least} up")
    return None if value is None else int(value)


def _streams(seed, run=0):
    return _count(seed, "seed", 0), _count(run, "run", 0)


class Verbs:
    """Mixed into Composition. Each composes the config anew, as the command does, and releases the GIL; Ctrl-C stops it."""

    _loaded: Any  # Composition's
    _load: Any
    run: Any

    def study(self, runs: int | None = None, jobs: int | None = None, *, seed: int | None = None) -> StudyResult:
        """Runs the variants of the config's "study" many times, as `binnacle study` does: a StudyResult.

        runs: of each variant, instead of the config's. jobs: at work at one time, all processors by default; the figures do
        not depend on it. Raises ConfigError where there is no "study".
        """
        jobs = _count(jobs, "jobs", 1) or 0
        return StudyResult(_core.study(self._loaded, _count(runs, "runs", 1), _count(seed, "seed", 0), jobs))

    def covariance(self, *, budget: bool = False) -> Analysis:
        """What the errors will be, from covariances alone, as `binnacle covariance` has it: an Analysis.

        budget: whether its text has every source's share too; the figures always do.
        """
        return Analysis(_core.covariance(self._loaded, budget))

    def tune(self, *, seed: int = 1, run: int = 0, jobs: int | None = None) -> Tuning:
        """Parameters of the config's "tune" by what the data say of them, as `binnacle tune` does: a Tuning."""
        return Tuning(_core.tune(self._loaded, *_streams(seed, run), _count(jobs, "jobs", 1) or 0))

    def observe(self, *windows: str, seed: int = 1, run: int = 0) -> Analysis:
        """Observability of a run: which states its measurements determine, as `binnacle observe` has it: an Analysis.

        windows: texts as --window takes them, "60:90" or the name of one; by default the whole run.
        """
        return Analysis(_core.observe(self._loaded, list(windows), *_streams(seed, run)))

    def smooth(self, seed: int = 1, **arguments: Any) -> RunResult:
        """run(), with every filter smoothed once it is over, as `binnacle run --smooth` does: r["ins.smoothed"] beside
        r["ins"]. arguments: those of run()."""
        made: Any = type(self)
        smoothed = made(_core.smoothed(self._loaded), lambda *more: _core.smoothed(self._load(*more)))
        return smoothed.run(seed, **arguments)

    def allan(self, channel: str, *, overlap: float = 1.0, seed: int = 1) -> AllanDeviation:
        """The noise of a channel by its Allan deviation, as `binnacle allan` has it: an AllanDeviation.

        overlap: averages overlap fully up to so many seconds. Raises ValueError where there is no such channel, DataError
        where no sample came.
        """
        return AllanDeviation(_core.allan(self._loaded, channel, overlap, _count(seed, "seed", 0)))

    def inspect(self) -> Analysis:
        """Looks at the data of the config before a filter does, as `binnacle inspect` does: an Analysis with "findings"."""
        return Analysis(_core.inspect_config(self._loaded))
