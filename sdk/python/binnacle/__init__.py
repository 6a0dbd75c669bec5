# SPDX-License-Identifier: Apache-2.0
"""Binnacle: error-state Kalman filters composed from JSON, run from Python at the speed of C++.

    import binnacle as bn
    result = bn.load("ins.json").run(seed=1)
    result["ins"]["position"]          # (n, 3), with .t, .sigma and .units

Numbers are in SI, angles in rad. Times are seconds (float), or numpy.timedelta64 where they have to be exact.
"""

from . import _numpy  # before all that wants numpy
from ._core import version as __version__
from ._composition import Composition, load, parse
from ._errors import ConfigError, DataError, Diagnostic, Error, FilterError, LoadError
from ._results import Errors, FilterResult, Innovations, Records, RunResult, Series

__all__ = [
    "Composition",
    "ConfigError",
    "DataError",
    "Diagnostic",
    "Error",
    "Errors",
    "FilterError",
    "FilterResult",
    "Innovations",
    "LoadError",
    "Records",
    "RunResult",
    "Series",
    "load",
    "parse",
]
