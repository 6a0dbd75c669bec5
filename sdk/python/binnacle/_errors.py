# SPDX-License-Identifier: Apache-2.0
"""What is wrong, and the exceptions that carry it."""

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Diagnostic:
    """One error or warning. line and column count from 1; 0 where they are not known."""

    severity: str  # "error" or "warning"
    code: str  # "B012"; `binnacle help B012` explains it
    file: str
    line: int
    column: int
    pointer: str  # JSON pointer into the resolved config; "" where there is none
    message: str
    text: str  # all of it in one line

    def __str__(self):
        return self.text


class Error(Exception):
    """Base of all that Binnacle raises. str() is one line for each of .diagnostics."""

    exit_status = 1
    diagnostics: list[Diagnostic]

    def __init__(self, text: str, diagnostics: Iterable[Diagnostic] = ()):
        super().__init__(text)
        self.diagnostics = list(diagnostics)


class FilterError(Error):
    """A filter broke."""

    exit_status = 1


class ConfigError(Error):
    """The config is wrong; .diagnostics has everything that is."""

    exit_status = 3


class LoadError(Error):
    """A plugin cannot be loaded."""

    exit_status = 4


class DataError(Error):
    """Data are missing or unusable."""

    exit_status = 5


_KINDS = {kind.exit_status: kind for kind in (FilterError, ConfigError, LoadError, DataError)}


for _kind in (Diagnostic, Error, *_KINDS.values()):
    _kind.__module__ = "binnacle"  # as users know them


def error_of(exit_status, text, diagnostics):
    return _KINDS.get(exit_status, Error)(text, diagnostics)
