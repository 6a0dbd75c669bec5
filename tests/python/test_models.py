# SPDX-License-Identifier: Apache-2.0
"""Models in Python: registered, composed, run, against the plugins of the same equations."""

import threading
import traceback

import binnacle as bn
import numpy as np
import pytest

ANCHORS = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 80.0]])


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    """Ranges from a point that moves to three anchors, and its coordinates, with noise, as files."""
    folder = tmp_path_factory.mktemp("world")
    random = np.random.default_rng(1)
    t = np.arange(1, 301) * 0.1
    truth = np.column_stack([30 + 2 * t, 20 + 10 * np.sin(0.2 * t)])
    ranges = np.linalg.norm(truth[:, None] - ANCHORS, axis=2) + 0.3 * random.standard_normal((len(t), 3))
    seen = truth + 0.5 * random.standard_normal(truth.shape)
    table = np.column_stack([t, seen, ranges])
    np.savetxt(folder / "world.csv", table, delimiter=",", header="t,x,y,r0,r1,r2", comments="", fmt="%.9f")
    return folder


def config(measurements, **filter):
    """A filter of a point that walks at random."""
    columns = {"x": {"unit": "m"}, "y": {"unit": "m"}, **{f"r{i}": {"unit": "m"} for i in range(3)}}
    return {
        "binnacle": 1,
        "sources": {"seen": {"type": "csv", "path": "world.csv", "time": {"column": "t"}, "columns": columns}},
        "filters": {
            "point": {
                "blocks": {"place": {"type": "core/vector", "size": 2, "unit": "m", "sigma": 10,
                                     "init": {"x0": 35, "x1": 25}}},
                "process": {"walk": {"type": "core/random_walk", "blocks": {"x": "place"}, "q": 3}},
                "measurements": measurements,
                **filter,
            }
        },
    }


def run(world, measurements, **filter):
    return bn.parse(config(measurements, **filter), name=world / "mine.json").run()


def measured(type, **more):
    return {"seen": {"type": type, "channel": "seen", **more}}


def text_of(diagnostics):
    return "\n".join(map(str, diagnostics))


LINEAR = {"fields": {"z0": "x", "z1": "y"}, "blocks": {"x": "place"}, "sigma": [0.5]}


@bn.register
class TwoCoordinates(bn.MeasurementModel):
    spec = bn.Spec(
        summary="A point of a plane, seen directly: z = x + v.",
        parameters=[bn.number("sigma", "m").above(0).required().about("white noise of a coordinate")],
        ports=[bn.reads("x", "vector:2:m").about("the point")],
        fields=[bn.field("z0", "m").about("first coordinate"), bn.field("z1", "m").about("second coordinate")],
        example={"channel": "seen", "blocks": {"x": "place"}, "sigma": "0.5 m"},
    )

    def __init__(self, binding):
        self.variance = binding.parameters["sigma"] ** 2
        binding.group("x", port="x")

    def linearize(self, sample, x):
        return sample.fields("z0", "z1") - x["x"], {"x": np.eye(2)}, np.full(2, self.variance)


class _Range(bn.MeasurementModel):
    spec = bn.Spec(
        summary="Distance to a point that is known: z = |x - a| + v.",
        parameters=[
            bn.number("sigma", "m").above(0).required().about("white noise of the distance"),
            bn.vector("anchor", "m", 2).required().about("where it is measured to"),
        ],
        ports=[bn.reads("position", "vector:2:m").about("the point")],
        fields=[bn.field("range", "m").about("measured distance")],
        example={"channel": "ranges", "blocks": {"position": "place"}, "sigma": "0.3 m", "anchor": ["100 m", "0 m"]},
        surroundings={"blocks": {"place": {"type": "core/vector", "size": 2, "unit": "m", "sigma": 1,
                                           "init": {"x0": 35, "x1": 25}}}, "sample": {"range": 70}},
    )

    def __init__(self, binding):
        self.variance, self.anchor = binding.parameters["sigma"] ** 2, binding.parameters["anchor"]
        binding.group("range", rows=1, unit="m")

    def predicted(self, x):
        d = x["position"] - self.anchor
        return np.hypot(*d), d


@bn.register
class MyRange(_Range):
    def linearize(self, sample, x):
        length, d = self.predicted(x)
        return sample["range"] - length, {"position": d / length}, self.variance


@bn.register(name="my_numeric_range")
class NumericRange(_Range):
    def linearize(self, sample, x):
        return sample["range"] - self.predicted(x)[0], None, self.variance


def three(type):
    """The three ranges, each a measurement."""
    return {
        f"r{i}": {"type": type, "channel": "seen", "blocks": {"position": "place"}, "fields": {"range": f"r{i}"},
                  "sigma": "0.3 m", "anchor": list(anchor)}
        for i, anchor in enumerate(ANCHORS)
    }


def test_a_model_gives_the_bits_of_the_plugin_of_its_equation(world):
    plugin = run(world, measured("core/linear_measurement", **LINEAR))["point"]
    python = run(world, measured("two_coordinates", **{**LINEAR, "sigma": 0.5}))["point"]
    assert np.array_equal(plugin["place"], python["place"]) and np.array_equal(plugin["place"].sigma, python["place"].sigma)
    assert np.array_equal(plugin.innovations["seen"].residual, python.innovations["seen"].residual)


def test_its_full_name_is_that_of_the_plugin_python(world):
    assert run(world, three("python/my_range")).verdict == run(world, three("my_range")).verdict


def test_jacobians_by_differences_are_those_by_hand(world):
    by_hand, by_differences = run(world, three("my_range"))["point"], run(world, three("my_numeric_range"))["point"]
    assert len(by_hand.innovations["r0"].t) == 300 and by_hand.innovations["r0"].accepted.all()
    np.testing.assert_allclose(by_differences["place"], by_hand["place"], rtol=0, atol=1e-8)
    np.testing.assert_allclose(by_differences["place"].sigma, by_hand["place"].sigma, rtol=1e-7)


def test_a_misspelt_type_is_near_one_in_python(world):
    with pytest.raises(bn.Error, match="my_range"):
        run(world, three("my_rnge"))


def test_wrong_parameters_are_told_as_of_any_plugin(world):
    wrong = three("my_range")
    wrong["r0"]["sigma"] = "-1 m"
    with pytest.raises(bn.ConfigError) as caught:
        run(world, wrong)
    assert any(d.pointer == "/filters/point/measurements/r0/sigma" for d in caught.value.diagnostics)


def test_explain_marks_what_is_written_in_python(world):
    explained = bn.parse(config(three("my_range")), name=world / "mine.json").explain()
    marks = explained["filters"][0]["written_in_python"]
    assert [mark["type"] for mark in marks] == ["python/my_range"] * 3


def test_others_that_are_registered_are_no_part_of_what_is_loaded(world):
    def versions(measurements):
        return bn.parse(config(measurements), name=world / "mine.json").plugins

    plain, mine = versions(measured("core/linear_measurement", **LINEAR)), versions(three("my_range"))
    assert plain != mine != versions(three("my_numeric_range"))

    @bn.register(name="not_used")
    class NotUsed(MyRange):
        pass

    assert versions(measured("core/linear_measurement", **LINEAR)) == plain and versions(three("my_range")) == mine


def test_version_changes_with_the_code(world):
    def version(sign):
        namespace = {"_Range": _Range, "__name__": __name__}
        exec(
            "class Changing(_Range):\n"
            "    def linearize(self, sample, x):\n"
            f"        return sample['range'] - self.predicted(x)[0] * {sign}, None, self.variance\n",
            namespace,
        )
        bn.register(namespace["Changing"], name="changing")
        return bn.parse(config(three("changing")), name=world / "mine.json").plugins["python"]

    assert version("1.0") == version("1.0") != version("1.5")


# ---- refusals and exceptions


def failing(body):
    class Failing(_Range):
        def linearize(self, sample, x):
            return body(self, sample, x)

    bn.register(Failing, name="failing")
    return {"r0": {**three("failing")["r0"]}}


def test_a_refusal_is_the_samples_fate(world):
    result = run(world, failing(lambda self, sample, x: bn.unsupported("too near") if sample.t > 10 else MyRange.linearize(self, sample, x)))
    innovations = result["point"].innovations["r0"]
    assert set(innovations.outcome[innovations.t > 10.05]) == {"unsupported"}
    assert set(innovations.reason[innovations.t > 10.05]) == {"too near"}


def test_an_exception_ends_the_filter_with_its_traceback(world):
    def body(self, sample, x):
        return helper(sample)

    def helper(sample):
        raise ZeroDivisionError("no such thing")

    text = text_of(run(world, failing(body)).failures)
    assert "plugin 'python', component 'failing' (/filters/point/measurements/r0): linearize at 0.1 s threw: " in text
    assert "ZeroDivisionError: no such thing" in text
    assert 'test_models.py:' in text and ' in helper: raise ZeroDivisionError("no such thing"); from test_models.py:' in text
    raised = bn.last_exception()
    assert type(raised) is ZeroDivisionError and traceback.extract_tb(raised.__traceback__)[-1].name == "helper"


@pytest.mark.parametrize(
    "answer, message",
    [
        (lambda self: (1.0, {"position": np.zeros((1, 3))}, 1.0), r"H of 'position' is of shape \(1, 3\); it takes \(1, 2\)"),
        (lambda self: (1.0, {}, 1.0), "H has no block of port 'position'"),
        (lambda self: (np.zeros(2), None, np.zeros(2)), "at most 1 rows"),
        (lambda self: (1.0, None, np.zeros((2, 2))), r"R is of shape \(2, 2\)"),
        (lambda self: None, "linearize gives None"),
        (lambda self: ("a", None, 1.0), "the residual is 'a', which is not an array of numbers"),
    ],
)
def test_a_wrong_answer_is_told_with_what_was_found_and_expected(world, answer, message):
    import re

    assert re.search(message, text_of(run(world, failing(lambda self, sample, x: answer(self))).failures))


def test_ctrl_c_in_a_model_is_ctrl_c(world):
    def body(self, sample, x):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(world, failing(body))
        for _ in range(1000):  # where Python looks next
            pass


def test_a_constructor_refuses_at_its_place(world):
    class Refusing(MyRange):
        def __init__(self, binding):
            raise bn.ComponentError("no such anchor", "/anchor")

    bn.register(Refusing, name="refusing")
    with pytest.raises(bn.ConfigError, match="no such anchor") as caught:
        run(world, three("refusing"))
    assert caught.value.diagnostics[0].pointer == "/filters/point/measurements/r0/anchor"


def test_a_bound_model_does_not_change(world):
    class Changing(MyRange):
        def linearize(self, sample, x):
            self.count = 1

    bn.register(Changing, name="changing_self")
    text = text_of(run(world, three("changing_self")).failures)
    assert "Changing.count is set after the model is bound" in text and "binding.keeps" in text

    class InPlace(MyRange):
        def linearize(self, sample, x):
            self.kept += 1

        def __init__(self, binding):
            super().__init__(binding)
            self.kept = np.zeros(2)

    bn.register(InPlace, name="in_place")
    assert "read-only" in text_of(run(world, three("in_place")).failures)


# ---- memory


@bn.register
class Counting(_Range):
    def __init__(self, binding):
        super().__init__(binding)
        binding.keeps({"count": 0, "sum": 0.0, "last": np.zeros(2)})

    def linearize(self, sample, x, memory, notes):
        memory["count"] += 1
        memory["sum"] += sample["range"]
        memory["last"][:] = x["position"]
        notes.append(f"count {memory['count']}")
        return MyRange.linearize(self, sample, x)


def test_memory_lives_as_long_as_the_run_and_no_longer(world):
    composition = bn.parse(config({"r0": three("counting")["r0"]}), name=world / "mine.json")
    for _ in range(2):
        warnings = "\n".join(map(str, composition.run().warnings))
        assert "count 1" in warnings and "count 2" in warnings


def test_a_gated_sample_leaves_no_trace_in_memory(world):
    @bn.register(name="counting_some")
    class CountingSome(Counting):
        def linearize(self, sample, x, memory, notes):
            residual, H, R = Counting.linearize(self, sample, x, memory, [])
            return residual + (1000.0 if sample.t_ns % 1_000_000_000 == 0 else 0.0) + 0.0 * memory["count"], H, R

        __doc__ = "Its samples at full seconds are nonsense."

    seen = []

    class Watching(CountingSome):
        def linearize(self, sample, x, memory, notes):
            answer = CountingSome.linearize(self, sample, x, memory, notes)
            seen.append(memory["count"])
            return answer

    bn.register(Watching, name="watching")
    measurement = {**three("watching")["r0"], "gate": 0.999, "recover": False}
    innovations = run(world, {"r0": measurement})["point"].innovations["r0"]
    assert np.count_nonzero(innovations.outcome == "gated") == 30
    assert seen[-1] == np.count_nonzero(innovations.accepted[:-1]) + 1


@bn.register
class Doubting(_Range):
    """Trusts each sample less than the one before, so that what it remembers shows."""

    def __init__(self, binding):
        super().__init__(binding)
        binding.keeps({"count": 0})

    def linearize(self, sample, x, memory):
        memory["count"] += 1
        residual, H, R = MyRange.linearize(self, sample, x)
        return residual, H, R * memory["count"]


def pushes(session, samples):
    """push(i): the i-th of the samples."""
    channel = session.channel("seen")
    fields = np.stack([samples[name] for name in channel.fields], axis=1)
    return lambda i: channel.push(None, samples.t[i], fields[i])


def estimate(session):
    return session.state().tobytes() + session.covariance().tobytes()


def test_a_snapshot_has_what_a_model_remembers(world):
    composition = bn.parse(config({"r0": three("doubting")["r0"]}), name=world / "mine.json")
    samples = composition.run(keep="seen").channels["seen"]

    def after(session, first, last):
        push = pushes(session, samples)
        for i in range(first, last):
            push(i)
        return estimate(session)

    session = composition.session()
    after(session, 0, 100)
    snapshot = session.snapshot()
    expected = after(session, 100, 200)
    session.restore(snapshot)
    assert after(session, 100, 200) == expected
    other = composition.session()
    other.restore(snapshot)
    assert after(other, 100, 200) == expected

    forgetful = composition.session()  # the same estimate at that time would not be enough
    after(forgetful, 0, 99)
    assert after(forgetful, 100, 200) != expected


def test_a_late_sample_finds_what_a_model_remembered_then(world):
    composition = bn.parse(config({"r0": three("doubting")["r0"]}, history="2 s"), name=world / "mine.json")
    samples = composition.run(keep="seen").channels["seen"]
    in_order, late = composition.session(), composition.session()
    push = pushes(in_order, samples)
    for i in range(60):
        push(i)
    push = pushes(late, samples)
    for i in (*range(40), *range(41, 50), 40, *range(50, 60)):
        push(i)
    assert late.counts("r0")["replayed"] == 1
    assert estimate(late) == estimate(in_order)


# ---- other roles


@bn.register
class Walk(bn.ProcessModel):
    spec = bn.Spec(
        summary="A random walk.",
        parameters=[bn.number("q", "@x/sqrt(s)").above(0).required().about("root of its spectral density")],
        ports=[bn.advances("x", "vector:*:*").about("what walks")],
        example={"blocks": {"x": "place"}, "q": 3},
    )

    def __init__(self, binding):
        self.q = binding.parameters["q"]
        self.dof = binding.ports["x"].dof

    def propagate(self, x, step):
        return {"x": x["x"]}, {}, {("x", "x"): np.full(self.dof, self.q**2 * step.dt)}


@bn.register(name="numeric_walk")
class NumericWalk(Walk):
    def propagate(self, x, step):
        x_plus, _, Qd = Walk.propagate(self, x, step)
        return x_plus, None, Qd


def test_a_process_gives_what_the_plugin_gives(world):
    def walk(type):
        process = {"walk": {"type": type, "blocks": {"x": "place"}, "q": 3}}
        return run(world, measured("core/linear_measurement", **LINEAR), process=process)["point"]

    plugin, python, numeric = walk("core/random_walk"), walk("python/walk"), walk("numeric_walk")
    assert np.array_equal(plugin["place"], python["place"]) and np.array_equal(plugin["place"].sigma, python["place"].sigma)
    np.testing.assert_allclose(numeric["place"].sigma, plugin["place"].sigma, rtol=1e-9)


@bn.register
class Pendulum(bn.ProcessModel):
    """Φ that is not the identity: the numeric one against the one by hand."""

    spec = bn.Spec(
        summary="A pendulum, by one Euler step.",
        parameters=[bn.boolean("by_hand").required().about("whether it gives its Jacobian")],
        ports=[bn.advances("angle", "vector:1:m").about("of the pendulum"),
               bn.advances("rate", "vector:1:m/s").about("of its angle")],
        example={"blocks": {"angle": "angle", "rate": "rate"}, "by_hand": True},
    )

    def __init__(self, binding):
        self.by_hand = binding.parameters["by_hand"]

    def propagate(self, x, step):
        dt, angle, rate = step.dt, x["angle"], x["rate"]
        Phi = {("angle", "rate"): dt, ("rate", "angle"): -np.cos(angle) * dt}
        x_plus = {"angle": angle + rate * dt, "rate": rate - np.sin(angle) * dt}
        return x_plus, Phi if self.by_hand else None, {("rate", "rate"): 0.01 * dt}


def test_transition_by_differences_is_that_by_hand(world):
    def swing(by_hand):
        blocks = {"angle": {"type": "core/vector", "size": 1, "unit": "m", "sigma": 1, "init": {"x": 1}},
                  "rate": {"type": "core/vector", "size": 1, "unit": "m/s", "sigma": 1}}
        process = {"p": {"type": "pendulum", "blocks": {"angle": "angle", "rate": "rate"}, "by_hand": by_hand}}
        seen = {"s": {"type": "core/linear_measurement", "channel": "seen", "blocks": {"x": "angle"}, "fields": {"z0": "x"},
                      "sigma": [1e4]}}
        return run(world, seen, blocks=blocks, process=process)["point"]

    by_hand, by_differences = swing(True), swing(False)
    for block in ("angle", "rate"):
        np.testing.assert_allclose(by_differences[block], by_hand[block], rtol=0, atol=1e-9)
        np.testing.assert_allclose(by_differences[block].sigma, by_hand[block].sigma, rtol=1e-8)
    assert np.ptp(by_hand["angle"].sigma) > 0.1


@bn.register
class Doubled(bn.NoiseEstimator):
    spec = bn.Spec(summary="Twice the nominal noise once it has seen ten samples.", example={})

    def __init__(self, binding):
        binding.keeps({"count": 0})

    def estimate(self, innovation, memory):
        return innovation.R * (2 if memory["count"] >= 10 else 1)

    def after(self, update, memory):
        memory["count"] += update.outcome == "accepted"


def test_a_noise_estimator_replaces_R(world):
    noise = run(world, measured("core/linear_measurement", **LINEAR, noise={"type": "doubled"}))["point"].innovations["seen"].noise
    noise = noise.reshape(-1, 2)[:, 0]
    np.testing.assert_allclose(noise[:10], 0.5)
    np.testing.assert_allclose(noise[10:], 0.5 * np.sqrt(2))


@bn.register
class Rotated(bn.DerivedBlock):
    spec = bn.Spec(
        summary="The point in turned axes.",
        parameters=[bn.boolean("by_hand").required().about("whether it gives its Jacobian")],
        ports=[bn.reads("place", "vector:2:m").about("the point")],
        kind="vector:2:m",
        example={"blocks": {"place": "place"}, "by_hand": True},
    )
    C = np.array([[0.8, 0.6], [-0.6, 0.8]])

    def __init__(self, binding):
        self.by_hand = binding.parameters["by_hand"]
        binding.yields_like("place")

    def evaluate(self, x):
        return self.C @ x["place"], {"place": self.C} if self.by_hand else None


def test_a_derived_block_is_measured_through(world):
    def turned(by_hand):
        derived = {"turned": {"type": "rotated", "blocks": {"place": "place"}, "by_hand": by_hand}}
        seen = measured("core/linear_measurement", **{**LINEAR, "blocks": {"x": "turned"}})
        return run(world, seen, derived=derived)["point"]

    by_hand, by_differences = turned(True), turned(False)
    plain = run(world, measured("core/linear_measurement", **LINEAR))["point"]
    last = slice(-50, None)
    np.testing.assert_allclose(by_hand["place"][last] @ Rotated.C.T, plain["place"][last], atol=1e-3)
    np.testing.assert_allclose(by_differences["place"], by_hand["place"], rtol=0, atol=1e-9)


@bn.register
class Halved(bn.Transform):
    spec = bn.Spec(
        summary="Every second sample, halved.",
        inputs=[bn.input("seen", [bn.field("x", "m").about("a coordinate")]).about("any")],
        example={"inputs": {"seen": "seen"}},
    )

    def __init__(self, binding):
        binding.emits("", [bn.field("half", "m")])
        binding.keeps({"count": 0})

    def on(self, sample, emit, memory):
        memory["count"] += 1
        if memory["count"] % 2 == 0:
            emit({"half": sample["x"] / 2})


def test_a_transform_makes_samples(world):
    made = config({"s": {"type": "core/linear_measurement", "channel": "half", "blocks": {"x": "place"}, "fields": {"z0": "half"},
                         "H": [[0.5, 0]], "sigma": [0.25]}})
    made["transforms"] = {"half": {"type": "halved", "inputs": {"seen": "seen"}}}
    innovations = bn.parse(made, name=world / "mine.json").run()["point"].innovations["s"]
    assert len(innovations.t) == 150 and innovations.accepted.all()
    np.testing.assert_allclose(innovations.t, np.arange(1, 151) * 0.2)


def test_an_exception_of_a_transform_ends_the_run(world):
    class Raising(Halved):
        def on(self, sample, emit, memory):
            emit({"whole": 1.0})

    bn.register(Raising, name="raising")
    made = config(measured("core/linear_measurement", **LINEAR))
    made["transforms"] = {"half": {"type": "raising", "inputs": {"seen": "seen"}}}
    with pytest.raises(bn.Error, match="component 'raising': on at 0.1 s threw: KeyError"):
        bn.parse(made, name=world / "mine.json").run()


# ---- threads


def test_two_runs_at_once_give_what_one_gives(world):
    composition = bn.parse(config({**three("my_range"), "seen": measured("counting")["seen"] | three("counting")["r0"]}),
                           name=world / "mine.json")
    alone, found = composition.run()["point"], [None] * 3

    def work(i):
        found[i] = composition.run()["point"]

    threads = [threading.Thread(target=work, args=(i,)) for i in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for each in found:
        assert np.array_equal(each["place"], alone["place"]) and np.array_equal(each["place"].sigma, alone["place"].sigma)


def test_registering_says_what_is_wrong():
    with pytest.raises(TypeError, match="is not derived from MeasurementModel"):
        bn.register(int)
    with pytest.raises(TypeError, match="takes 'memry'; besides its 2 there are memory"):

        @bn.register
        class Misspelt(_Range):
            def linearize(self, sample, x, memry):
                pass

    with pytest.raises(TypeError, match="spec is None"):

        @bn.register
        class WithoutSpec(bn.MeasurementModel):
            pass
