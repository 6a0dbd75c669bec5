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
from ._conform import Conformance, Finding, conform
from ._core import Inflation, Step, Update
from ._core import (
    advances,
    boolean,
    choice,
    field,
    increment,
    input,
    integer,
    list_of,
    map_of,
    matrix,
    number,
    object_of,
    path,
    rate,
    reads,
    text,
    time,
    vector,
)
from ._errors import ConfigError, DataError, Diagnostic, Error, FilterError, LoadError
from ._log import LoggedUpdate, StepLog
from ._models import (
    ComponentError,
    DerivedBlock,
    MeasurementModel,
    NoiseEstimator,
    ProcessModel,
    Spec,
    Transform,
    cfunc,
    failed,
    invalid,
    last_exception,
    register,
    unsupported,
)
from ._results import Errors, FilterResult, Innovations, Metrics, Records, RunResult, Series, StudyResult, open
from ._session import Session
from ._verbs import AllanDeviation, Analysis, Tuning

__all__ = [
    "AllanDeviation",
    "Analysis",
    "Arrays",
    "ComponentError",
    "Composition",
    "ConfigError",
    "Conformance",
    "DataError",
    "DerivedBlock",
    "Diagnostic",
    "Error",
    "Errors",
    "FilterError",
    "FilterResult",
    "Finding",
    "Inflation",
    "Innovations",
    "LoadError",
    "LoggedUpdate",
    "MeasurementModel",
    "Metrics",
    "NoiseEstimator",
    "ProcessModel",
    "Records",
    "RunResult",
    "Samples",
    "Series",
    "Session",
    "Spec",
    "Step",
    "StepLog",
    "StudyResult",
    "Transform",
    "Tuning",
    "Update",
    "advances",
    "allan",
    "boolean",
    "cfunc",
    "choice",
    "conform",
    "failed",
    "field",
    "increment",
    "input",
    "inspect",
    "integer",
    "invalid",
    "last_exception",
    "list_of",
    "load",
    "map_of",
    "matrix",
    "number",
    "object_of",
    "open",
    "parse",
    "path",
    "rate",
    "reads",
    "register",
    "text",
    "time",
    "unsupported",
    "vector",
]
