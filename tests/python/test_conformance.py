# SPDX-License-Identifier: Apache-2.0
"""conform() on models in Python: good ones pass, and each faulty one is caught by the check that is made for it."""

import binnacle as bn
import numpy as np
import pytest


class Range(bn.MeasurementModel):
    spec = bn.Spec(
        summary="Distance to a point that is known: z = |x - a| + v.",
        parameters=[
            bn.number("sigma", "m").above(0).required().about("white noise of the distance"),
            bn.vector("anchor", "m", 2).defaults(["100 m", "0 m"]).about("where it is measured to"),
        ],
        ports=[bn.reads("position", "vector:2:m").about("the point")],
        fields=[bn.field("range", "m").about("measured distance")],
        example={"channel": "ranges", "blocks": {"position": "place"}, "sigma": "0.3 m"},
        surroundings={
            "blocks": {"place": {"type": "core/vector", "size": 2, "unit": "m", "sigma": 0.5, "init": {"x0": 30, "x1": 20}}},
            "sample": {"range": 73},
        },
    )

    def __init__(self, binding):
        self.variance, self.anchor = binding.parameters["sigma"] ** 2, binding.parameters["anchor"]
        binding.group("range", rows=1, unit="m")

    def linearize(self, sample, x):
        d = x["position"] - self.anchor
        length = np.hypot(*d)
        if not (np.isfinite(length) and length > 1e-3):
            return bn.unsupported("at the anchor")
        return sample["range"] - length, {"position": d / length}, self.variance


class ByDifferences(Range):
    def linearize(self, sample, x):
        answer = Range.linearize(self, sample, x)
        return (answer[0], None, answer[2]) if len(answer) == 3 else answer


class Remembering(Range):
    """The mean of the residuals so far is its bias."""

    def __init__(self, binding):
        super().__init__(binding)
        binding.keeps({"count": 0, "sum": 0.0})

    def linearize(self, sample, x, memory):
        answer = Range.linearize(self, sample, x)
        if len(answer) != 3:
            return answer
        bias = memory["sum"] / max(memory["count"], 1)
        memory["count"] = min(max(memory["count"], 0), 1000) + 1
        memory["sum"] = float(np.clip(np.nan_to_num(memory["sum"]), -1e3, 1e3)) * 0.5 + 1e-3 * sample["range"]
        return answer[0] - np.clip(np.nan_to_num(bias), -1, 1), *answer[1:]


class WrongSign(Range):
    def linearize(self, sample, x):
        residual, H, R = Range.linearize(self, sample, x)
        return residual, {"position": -H["position"]}, R


class HiddenState(Range):
    def __init__(self, binding):
        super().__init__(binding)
        self.count = 0

    def linearize(self, sample, x):
        object.__setattr__(self, "count", self.count + 1)
        residual, H, R = Range.linearize(self, sample, x)
        return residual + 1e-6 * self.count, H, R


class HiddenList(Range):
    def __init__(self, binding):
        super().__init__(binding)
        self.seen = []

    def linearize(self, sample, x):
        self.seen.append(sample["range"])
        residual, H, R = Range.linearize(self, sample, x)
        return residual, H, R * (1 + 1e-6 * len(self.seen))


_seen = {"count": 0}


class HiddenGlobal(Range):
    def linearize(self, sample, x):
        _seen["count"] += 1
        residual, H, R = Range.linearize(self, sample, x)
        return residual + 1e-6 * _seen["count"], H, R


class SilentState(Range):
    """It shows in nothing that it gives, so far."""

    def __init__(self, binding):
        super().__init__(binding)
        self.seen = {}

    def linearize(self, sample, x):
        self.seen[len(self.seen)] = sample["range"]
        return Range.linearize(self, sample, x)


class Random(Range):
    def linearize(self, sample, x):
        residual, H, R = Range.linearize(self, sample, x)
        return residual + 1e-9 * np.random.standard_normal(), H, R


class Asymmetric(Range):
    def __init__(self, binding):
        super().__init__(binding)
        binding.rows(2)

    def linearize(self, sample, x):
        residual, H, R = Range.linearize(self, sample, x)
        H = np.vstack([H["position"], H["position"]])
        return np.array([residual, residual]), {"position": H}, np.array([[R, 0.5 * R], [0.1 * R, R]])


class ChangesItsInput(Range):
    def linearize(self, sample, x):
        x["position"] -= self.anchor
        return sample["range"] - np.hypot(*x["position"]), None, self.variance


@pytest.mark.parametrize("model", [Range, ByDifferences, Remembering])
def test_a_good_model_conforms(model):
    conformance = bn.conform(model)
    assert not conformance, str(conformance)
    tried = {outcome.check: outcome.status for outcome in conformance.outcomes}
    assert tried["numbers.measurement.jacobian"] == tried["life.repeatable"] == tried["life.threads"] == "pass"
    assert tried["numbers.measurement.consistency"] == "pass"
    assert tried["life.snapshot"] == ("pass" if model is Remembering else "not applicable")


@pytest.mark.parametrize(
    "model, check, message",
    [
        (WrongSign, "numbers.measurement.jacobian", "by differences"),
        (HiddenState, "life.repeatable", "a state of its own"),
        (HiddenList, "life.repeatable", "a state of its own"),
        (HiddenGlobal, "life.repeatable", "a state of its own"),
        (Random, "life.repeatable", "a state of its own"),
        (Asymmetric, "numbers.measurement.noise", "symmetric"),
        (ChangesItsInput, "life.calls", "read-only"),
        (SilentState, "python.unchanged", "seen"),
    ],
)
def test_a_faulty_model_is_caught(model, check, message):
    found = {finding.check: finding.message for finding in bn.conform(model) if finding.status == "fail"}
    assert message in found[check]


class Growth(bn.ProcessModel):
    sign = 1

    spec = bn.Spec(
        summary="Decay towards zero: x' = -x/tau + w.",
        parameters=[bn.number("tau", "s").above(0).required().about("time constant"),
                    bn.number("q", "@x/sqrt(s)").above(0).required().about("root of the noise's spectral density")],
        ports=[bn.advances("x", "vector:*:*").about("what decays")],
        example={"blocks": {"x": "x"}, "tau": "30 s", "q": 0.1},
    )

    def __init__(self, binding):
        self.tau, self.q, self.dof = binding.parameters["tau"], binding.parameters["q"], binding.ports["x"].dof

    def propagate(self, x, step):
        phi = np.exp(-step.dt / self.tau)
        Qd = self.q**2 * self.tau / 2 * -np.expm1(-2 * step.dt / self.tau)
        return {"x": phi * x["x"]}, {("x", "x"): self.sign * phi * np.eye(self.dof)}, {("x", "x"): np.full(self.dof, Qd)}


class WrongGrowth(Growth):
    sign = -1


def test_processes():
    conformance = bn.conform(Growth)
    assert not conformance, str(conformance)
    failed = {finding.check for finding in bn.conform(WrongGrowth) if finding.status == "fail"}
    assert failed == {"numbers.process.jacobian", "numbers.process.rest"}


def test_what_is_not_tried_is_told():
    conformance = bn.conform(WrongSign)
    assert any(outcome.check == "numbers.measurement.consistency" for outcome in conformance.untried)
    assert "prerequisite numbers.measurement.jacobian failed" in str(conformance)
