# SPDX-License-Identifier: Apache-2.0
"""Configs: loaded from a file, or made of a dict or text."""

import json
import os

from . import _core
from ._results import RunResult


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


def load(path, *, set=None, vars=None):
    """A config from a file, checked and composed.

    set: {"/json/pointer": value}, as --set of the command takes them; vars: {"name": text}, as --var does.
    Raises ConfigError, LoadError or DataError, each with .diagnostics: all that is wrong at once.
    """
    return Composition(_core.load(os.fspath(path), None, _vars(vars), _sets(set), _plugin_folders()))


def parse(config, *, name="config.json", set=None, vars=None):
    """The same of a dict, or of JSON text. Messages call it `name`; relative paths in it start at the folder of `name`."""
    text = config if isinstance(config, str) else json.dumps(config, indent=2)
    return Composition(_core.load(os.fspath(name), text, _vars(vars), _sets(set), _plugin_folders()))


class Explanation(dict):
    """As `binnacle explain --json` gives it; str() is the text."""

    def __init__(self, explained, text):
        super().__init__(explained)
        self._text = text

    def __str__(self):
        return self._text


class Composition:
    """A checked config, ready to run any number of times, in any number of threads. Made by load() and parse()."""

    def __init__(self, loaded):
        self._loaded = loaded

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

    @property
    def plugins(self):
        """Versions of the plugins that are loaded, by name; "python" is that of models in Python."""
        return self._loaded.plugins

    def explain(self):
        """A dry run: layout of the state, who moves and reads what, what is written in Python. A dict; str() is what
        `binnacle explain` prints."""
        return Explanation(*self._loaded.explain())

    def check(self):
        """What is suspicious but no error: a list of Diagnostic. (What is an error, load() and parse() raise.)"""
        return self._loaded.warnings()

    def run(self, seed=1, *, run=0, records=True, innovations=True):
        """Runs it over its sources, as `binnacle run` does, with the same numbers to the last bit: a RunResult.

        seed, run: which random streams simulators draw from. records, innovations: whether estimates and the fate of
        samples are kept; both are held in memory, as float64. The GIL is released; Ctrl-C stops the run
        (KeyboardInterrupt). Raises DataError where data turn out unusable.
        """
        return RunResult(_core.run(self._loaded, seed, run, records, innovations))
