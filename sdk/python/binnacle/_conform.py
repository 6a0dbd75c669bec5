# SPDX-License-Identifier: Apache-2.0
"""The conformance suite on models in Python, in process."""

from dataclasses import dataclass

from . import _core, _models
from ._composition import _plugin_folders


@dataclass(frozen=True)
class Finding:
    """What became of one check. `binnacle conform --list` says what each holds a component to."""

    check: str  # "numbers.measurement.jacobian"
    status: str  # "fail", "warn", "pass", "skip" (it could not be tried) or "not applicable"
    message: str

    def __str__(self):
        return f"{self.status}: {self.check}: {self.message}" if self.message else f"{self.status}: {self.check}"


class Conformance(list):
    """Findings that fail or warn; empty: none was found. .outcomes has every check, those that could not be tried included."""

    def __init__(self, outcomes):
        self.outcomes = outcomes
        super().__init__(outcome for outcome in outcomes if outcome.status in ("fail", "warn"))

    @property
    def untried(self):
        """Checks that say something of the model and could not be tried."""
        return [outcome for outcome in self.outcomes if outcome.status == "skip"]

    def __str__(self):
        return "\n".join(map(str, [*self, *self.untried])) or f"{len(self.outcomes)} checks, nothing found"


def conform(model, level=5, seed=1):
    """Holds a model against the contract: what it declares, same input same bits, snapshots, threads, Jacobians against
    differences, R, hostile numbers and parameters, on the example of its spec. A Conformance: a list of Finding.

    model: a class, which is registered if it is not yet, or the name of one that is. level: 1 (quick) to 10 (thorough).
    What only a process of its own can show (crashes, leaks, endless loops) is not tried.
    """
    if not isinstance(model, str):
        if "_registered_name" not in vars(model):
            _models.register(model)
        model = model._registered_name
    return Conformance([Finding(*outcome) for outcome in _core.conform_model(model, level, seed, _plugin_folders())])
