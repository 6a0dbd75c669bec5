# SPDX-License-Identifier: Apache-2.0
"""Configs: loaded from a file, or made of a dict or text."""

import json
import os
from collections.abc import Iterable, Mapping
from typing import Any

from . import _core
from ._arrays import Keeper, refuse_unused, settings_of
from ._errors import Diagnostic
from ._results import Figures, RunResult
from ._session import Session
from ._verbs import AllanDeviation, Analysis, Verbs, _count, _streams


Path = str | os.PathLike[str]


def _plugin_folders():
    """Where plugins lie: inside this package, as in a wheel; beside it, in the build tree; where the project is installed."""
    here = os.path.dirname(os.path.abspath(_core.__file__))
    inside = os.path.join(here, "lib", "binnacle")
    if os.path.isdir(inside):
        return [inside]
    folders = [os.path.normpath(os.path.join(here, "..", "..", "lib", "binnacle"))]
    # lib/python3/dist-packages/binnacle of the same prefix
    prefix = os.path.normpath(os.path.join(here, "..", "..", "..", ".."))
    folders.append(os.path.join(prefix, "lib", "binnacle"))
    return [folder for folder in folders if os.path.isdir(folder)]


def _sets(settings):
    return [pointer + "=" + json.dumps(value) for pointer, value in (settings or {}).items()]


def _vars(variables):
    return {name: str(value) for name, value in (variables or {}).items()}


def load(
    path: Path,
    *,
    set: Mapping[str, Any] | None = None,
    vars: Mapping[str, object] | None = None,
    data: Mapping[str, Any] | None = None,
    variant: str | None = None,
) -> "Composition":
    """A config from a file, checked and composed.

    set: {"/json/pointer": value}, as --set of the command takes them; vars: {"name": text}, as --var does.
    data: {"imu": (t, {"wx": array})}: arrays in the place of that source, or as one of that name where there is none; see
    Arrays for kinds, units and intervals. They are copied once. variant: the name of one of the config's study, as --variant.
    A config that is complete only as a variant of its study loads without variant, too: study() and covariance() work, run()
    raises what is missing.
    Raises ConfigError, LoadError or DataError, each with .diagnostics: all that is wrong at once.
    """
    return _composed(os.fspath(path), None, vars, set, data, variant)


def parse(
    config: Mapping[str, Any] | str,
    *,
    name: Path = "config.json",
    set: Mapping[str, Any] | None = None,
    vars: Mapping[str, object] | None = None,
    data: Mapping[str, Any] | None = None,
    variant: str | None = None,
) -> "Composition":
    """The same of a dict, or of JSON text. Messages call it `name`; relative paths in it start at the folder of `name`."""
    text = config if isinstance(config, str) else json.dumps(config, indent=2)
    return _composed(os.fspath(name), text, vars, set, data, variant)


def _composed(path, text, variables, settings, data, variant):
    variables, settings = _vars(variables), dict(settings or {})

    def load(settings, variant=variant or ""):
        return _core.load(path, text, variables, _sets(settings), _plugin_folders(), variant)

    def load_with(more, *variant):
        return load({**settings, **more}, *variant)

    if not data:
        return Composition(load(settings), load_with)
    resolved = _core.resolved(path, text, variables, _sets(settings))
    of_data, held = settings_of(data, resolved)
    settings.update(of_data)
    loaded = load(settings)
    refuse_unused(data, resolved, loaded)
    del held  # the sources of the composition have them now
    return Composition(loaded, load_with)


class Composition(Verbs):
    """A checked config, ready to run any number of times, in any number of threads. Made by load() and parse()."""

    def __init__(self, loaded, load):
        self._loaded, self._load, self._keeper = loaded, load, Keeper(loaded, load)

    def __repr__(self) -> str:
        of = ", ".join(self.filters) or "no filter" if self._loaded.is_complete else "complete only as a variant of its study"
        return f"<binnacle.Composition {self._loaded.path!r}: {of}>"

    @property
    def title(self) -> str:
        return str(self.config.get("title", ""))

    @property
    def variants(self) -> list[str]:
        """Names of the variants of the config's study; none where it has no study."""
        return self._loaded.variants

    def variant(self, name: str) -> "Composition":
        """One variant of the config's study, as --variant of the command: a Composition of its own."""
        return Composition(self._load({}, name), lambda more: self._load(more, name))

    @property
    def filters(self) -> list[str]:
        """Names, in the order of the config."""
        return self._loaded.filters

    @property
    def channels(self) -> list[str]:
        """Names of all channels, of sources and of transforms."""
        return self._loaded.channels

    @property
    def config(self) -> dict[str, Any]:
        """The config as resolved: a dict, extends merged, variables and settings applied."""
        return self._loaded.config()

    @property
    def plugins(self) -> dict[str, str]:
        """Versions of the plugins that are loaded, by name; "python" is that of models in Python."""
        return self._loaded.plugins

    def explain(self) -> Figures:
        """A dry run: layout of the state, who moves and reads what, what is written in Python. A dict; str() is what
        `binnacle explain` prints."""
        return Figures(*self._loaded.explain())

    def check(self) -> list[Diagnostic]:
        """What `binnacle check` says: a list of Diagnostic, what is suspicious but no error.

        What is an error of the config itself, load() and parse() raise; of a variant of its study, or of "tune", this raises.
        """
        return self._loaded.warnings()

    def run(
        self,
        seed: int = 1,
        *,
        run: int = 0,
        records: bool = True,
        innovations: bool = True,
        keep: str | Iterable[str] = (),
        log: bool | str | Iterable[str] | Mapping[str, Iterable[str]] | None = None,
        observers: Mapping[str, Any] | None = None,
        out: Path | None = None,
    ) -> RunResult:
        """Runs it over its sources, as `binnacle run` does, with the same numbers to the last bit: a RunResult.

        seed, run: which random streams simulators draw from. records, innovations: whether estimates and the fate of
        samples are kept; both are held in memory, as float64. keep: names of channels, ["detector.stops"], whose samples
        are kept too, in .channels; the config is composed anew for them, with a sink each. The GIL is released; Ctrl-C
        stops the run (KeyboardInterrupt). Raises DataError where data turn out unusable.

        log: True, a filter's name, or a list of them: their whole step log is kept, r["ins"].log, a StepLog. A step takes 8
        bytes × (4 n² + 2 × stored size) for n rows of P, 7 kB for 15, and a sample about as much. {"ins": ("transition", …)}
        keeps what is named alone: of "step_covariance" (P0, P1 of steps), "transition" (Phi, Qd), "update_covariance" (P0, P1
        of samples), "jacobian" (H), "reset"; the rest is always kept.

        observers: {filter: observer}. An observer is called with each Step and each Update; or it has some of the methods
        stepped(step), offered(update), inflated(inflation), started(t, x, P), restored(t, x, P), rewound(t), which are called.
        Its attribute `wants` (names as above) says what is computed for it; by default all. Records are there during the call
        only, and each array that is read of them is a copy, made then. An exception ends the run and is raised here as it is.

        out: a folder for what `binnacle run --out` leaves there.
        """
        kept = (records, innovations, self._logs(log), self._observers(observers))
        arguments: tuple[Any, ...] = (*_streams(seed, run), *kept, None if out is None else os.fspath(out))
        run_one = lambda loaded: RunResult(_core.run(loaded, *arguments), self.config)  # noqa: E731
        if not keep:
            return run_one(self._loaded)
        result, result.channels = self._keeper.run(keep, run_one)
        return result

    def session(self, seed: int = 0, *, run: int = 0, estimates: str = "live") -> Session:
        """A Session: this composition inside your program, without its sources.

        seed, run: of the random streams of its models. estimates: where a filter has `history`, what all that is asked for
        is of: "live", with all that has come so far, or "settled", once no sample can change it any more.
        """
        return Session(self._loaded, seed, run, estimates)

    def _known_filter(self, name, argument):
        if name not in self.filters:
            known = ", ".join(map(repr, self.filters)) or "none"
            raise KeyError(f"{argument}: there is no filter {name!r}; there are {known}")
        return name

    def _logs(self, log):
        if not log:
            return {}
        if log is True:
            log = self.filters
        elif isinstance(log, str):
            log = [log]
        everything = ("step_covariance", "transition", "update_covariance", "jacobian", "reset")
        wants = dict(log) if isinstance(log, dict) else dict.fromkeys(log, everything)
        return {self._known_filter(name, "log"): list(names) for name, names in wants.items()}

    def _observers(self, observers):
        return {self._known_filter(name, "observers"): observer for name, observer in (observers or {}).items()}


def inspect(
    *files: "Path | Composition", vars: Mapping[str, object] | None = None, set: Mapping[str, Any] | None = None
) -> Analysis:
    """Looks at data before a filter does, as `binnacle inspect` does: units, signs, axes, clocks, mounting. An Analysis.

    files: data files, a config's file, or one Composition.
    """
    if len(files) == 1 and isinstance(files[0], Composition):
        return files[0].inspect()
    if not files:
        raise TypeError("inspect() takes data files, a config's file, or a Composition; found nothing")
    names = [os.fspath(file) for file in files]  # type: ignore[arg-type]  # a Composition among them is a TypeError
    return Analysis(_core.inspect_files(names, _described(names[0], vars, set)))


def allan(
    config: "Path | Composition",
    channel: str,
    *,
    overlap: float = 1.0,
    seed: int = 1,
    vars: Mapping[str, object] | None = None,
    set: Mapping[str, Any] | None = None,
) -> AllanDeviation:
    """The noise of a channel by its Allan deviation, as `binnacle allan` has it: an AllanDeviation.

    config: a Composition, or a config's file, of which nothing but the sources and transforms has to be right.
    """
    if isinstance(config, Composition):
        return config.allan(channel, overlap=overlap, seed=seed)
    return AllanDeviation(_core.allan(_described(config, vars, set), channel, overlap, _count(seed, "seed", 0)))


def _described(path, variables, settings):
    return _core.described(os.fspath(path), None, _vars(variables), _sets(settings), _plugin_folders())
