# SPDX-License-Identifier: Apache-2.0
"""Configs: loaded from a file, or made of a dict or text."""

import json
import os

from . import _core
from ._arrays import Keeper, refuse_unused, settings_of
from ._results import RunResult
from ._session import Session


def _plugin_folders():
    """Where plugins lie beside this package: in the build tree, or where the project is installed."""
    here = os.path.dirname(os.path.abspath(_core.__file__))
    folders = [os.path.normpath(os.path.join(here, "..", "..", "lib", "binnacle"))]
    # lib/python3/dist-packages/binnacle of the same prefix
    prefix = os.path.normpath(os.path.join(here, "..", "..", "..", ".."))
    folders.append(os.path.join(prefix, "lib", "binnacle"))
    return [folder for folder in folders if os.path.isdir(folder)]


def _sets(settings):
    return [pointer + "=" + json.dumps(value) for pointer, value in (settings or {}).items()]


def _vars(variables):
    return {name: str(value) for name, value in (variables or {}).items()}


def load(path, *, set=None, vars=None, data=None):
    """A config from a file, checked and composed.

    set: {"/json/pointer": value}, as --set of the command takes them; vars: {"name": text}, as --var does.
    data: {"imu": (t, {"wx": array})}: arrays in the place of that source, or as one of that name where there is none; see
    Arrays for kinds, units and intervals. They are copied once.
    Raises ConfigError, LoadError or DataError, each with .diagnostics: all that is wrong at once.
    """
    return _composed(os.fspath(path), None, vars, set, data)


def parse(config, *, name="config.json", set=None, vars=None, data=None):
    """The same of a dict, or of JSON text. Messages call it `name`; relative paths in it start at the folder of `name`."""
    text = config if isinstance(config, str) else json.dumps(config, indent=2)
    return _composed(os.fspath(name), text, vars, set, data)


def _composed(path, text, variables, settings, data):
    variables, settings = _vars(variables), dict(settings or {})
    load = lambda more: _core.load(path, text, variables, _sets(more), _plugin_folders())  # noqa: E731
    if not data:
        return Composition(load(settings), lambda more: load({**settings, **more}))
    resolved = _core.resolved(path, text, variables, _sets(settings))
    of_data, held = settings_of(data, resolved)
    settings.update(of_data)
    loaded = load(settings)
    refuse_unused(data, resolved, loaded)
    del held  # the sources of the composition have them now
    return Composition(loaded, lambda more: load({**settings, **more}))


class Composition:
    """A checked config, ready to run any number of times, in any number of threads. Made by load() and parse()."""

    def __init__(self, loaded, load):
        self._loaded, self._keeper = loaded, Keeper(loaded, load)

    def __repr__(self):
        return f"<binnacle.Composition {self._loaded.path!r}: {', '.join(self.filters) or 'no filter'}>"

    @property
    def title(self):
        return self._loaded.title

    @property
    def filters(self):
        """Names, in the order of the config."""
        return self._loaded.filters

    @property
    def channels(self):
        """Names of all channels, of sources and of transforms."""
        return self._loaded.channels

    @property
    def config(self):
        """The config as resolved: a dict, extends merged, variables and settings applied."""
        return self._loaded.config()

    def check(self):
        """What is suspicious but no error: a list of Diagnostic. (What is an error, load() and parse() raise.)"""
        return self._loaded.warnings()

    def run(self, seed=1, *, run=0, records=True, innovations=True, keep=()):
        """Runs it over its sources, as `binnacle run` does, with the same numbers to the last bit: a RunResult.

        seed, run: which random streams simulators draw from. records, innovations: whether estimates and the fate of
        samples are kept; both are held in memory, as float64. keep: names of channels, ["detector.stops"], whose samples
        are kept too, in .channels; the config is composed anew for them, with a sink each. The GIL is released; Ctrl-C
        stops the run (KeyboardInterrupt). Raises DataError where data turn out unusable.
        """
        run_one = lambda loaded: RunResult(_core.run(loaded, seed, run, records, innovations))  # noqa: E731
        if not keep:
            return run_one(self._loaded)
        result, result.channels = self._keeper.run(keep, run_one)
        return result

    def session(self, seed=0, *, run=0, estimates="live"):
        """A Session: this composition inside your program, without its sources.

        seed, run: of the random streams of its models. estimates: where a filter has `history`, what all that is asked for
        is of: "live", with all that has come so far, or "settled", once no sample can change it any more.
        """
        return Session(self._loaded, seed, run, estimates)
