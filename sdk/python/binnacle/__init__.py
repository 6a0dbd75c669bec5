# SPDX-License-Identifier: Apache-2.0
"""Binnacle: error-state Kalman filters composed from JSON, run from Python at the speed of C++.

    import binnacle as bn
    result = bn.load("ins.json").run(seed=1)
    result["ins"]["position"]          # (n, 3), with .t, .sigma and .units

Numbers are in SI, angles in rad. Times are seconds (float), or numpy.timedelta64 where they have to be exact.
"""

from . import _numpy  # before all that wants numpy
from ._core import version as __version__
from ._arrays import Arrays, Samples
from ._composition import Composition, allan, inspect, load, parse
from ._core import Inflation, Step, Update
from ._errors import ConfigError, DataError, Diagnostic, Error, FilterError, LoadError
from ._log import LoggedUpdate, StepLog
from ._results import Errors, FilterResult, Innovations, Metrics, Records, RunResult, Series, StudyResult, open
from ._session import Session
from ._verbs import AllanDeviation, Analysis, Tuning

__all__ = [
    "AllanDeviation",
    "Analysis",
    "Arrays",
    "Composition",
    "ConfigError",
    "DataError",
    "Diagnostic",
    "Error",
    "Errors",
    "FilterError",
    "FilterResult",
    "Inflation",
    "Innovations",
    "LoadError",
    "LoggedUpdate",
    "Metrics",
    "Records",
    "RunResult",
    "Samples",
    "Series",
    "Session",
    "Step",
    "StepLog",
    "StudyResult",
    "Tuning",
    "Update",
    "allan",
    "inspect",
    "load",
    "open",
    "parse",
]
