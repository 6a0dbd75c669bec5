# SPDX-License-Identifier: Apache-2.0
"""study, covariance, smooth, tune, observe, allan and inspect, against the command."""

import json
import re
import signal
import threading
import time

import binnacle as bn
import numpy as np
import pytest


LONG = {"/sources/drive/repeat": 1000}


def untimed(text):
    """Without times of the clock."""
    return [re.sub(r"wall time.*|, [^,]* per step", "", line) for line in text.splitlines()]


@pytest.fixture(scope="module")
def study(project):
    return bn.load(project / "configs" / "transfer_alignment" / "table3.json").study(runs=2, jobs=2, seed=5)


def test_a_study_has_the_figures_and_the_text_of_the_command(study, command, figures_of):
    line = ("study", "configs/transfer_alignment/table3.json", "--runs", "2", "--seed", "5", "--quiet")
    assert figures_of(dict(study.summary)) == figures_of(command(*line, "--json"))
    assert untimed(str(study.summary)) == untimed(command(*line[:-1]))
    assert (study.runs, study.seed, study.failures) == (2, 5, {})


def test_values_of_a_study_are_those_that_its_figures_are_made_of(study):
    for variant, metrics in study.items():
        for metric, values in metrics.items():
            figures = study.summary["variants"][variant]["metrics"][metric]
            assert values.shape == (2,) and figures["n"] == 2
            scale = figures["rms"] / np.sqrt(np.mean(values**2))
            assert figures["mean"] == pytest.approx(scale * np.mean(values), rel=1e-12)
            assert figures["max"] == pytest.approx(scale * np.max(np.abs(values)), rel=1e-12)
            assert (scale == pytest.approx(1)) == (metrics.units[metric] == metrics.display_units[metric])


def test_a_study_does_not_depend_on_its_jobs(project, study, figures_of):
    alone = bn.load(project / "configs" / "transfer_alignment" / "table3.json").study(2, 1, seed=5)
    assert figures_of(dict(alone.summary)) == figures_of(dict(study.summary))
    assert all(np.array_equal(alone[v][m], study[v][m]) for v in study for m in study[v])


def test_a_study_that_is_not_there_is_a_config_error(project):
    with pytest.raises(bn.ConfigError, match="study"):
        bn.load(project / "configs" / "quickstart.json").study(runs=1)
    with pytest.raises(ValueError, match="jobs is 0"):
        bn.load(project / "configs" / "quickstart.json").study(jobs=0)


def test_a_config_that_is_complete_only_as_a_variant(project):
    config = bn.load(project / "configs" / "ins_gps" / "turns.json")
    assert config.variants == ["lc low", "lc high", "tc low", "tc high"]
    assert config.title == "INS/GPS, large turns" and "as a variant" in repr(config)
    assert config.study(runs=1).summary["runs"] == 1
    with pytest.raises(bn.ConfigError, match="gyro_noise") as caught:
        config.run()
    assert "'tc low'" in str(caught.value)
    # Of the variants, too, everything is checked at once.
    with pytest.raises(bn.ConfigError, match="initial_sigma"):
        bn.load(project / "configs" / "ins_gps" / "turns.json", set={"/sources/drive/initial_sigmas": 1})


def test_one_variant(project, command, figures_of, tmp_path):
    path = project / "configs" / "ins_gps" / "turns.json"
    command("run", path, "--variant", "lc low", "--summary", tmp_path / "summary.json", "--quiet", status=(0, 1))
    expected = figures_of(json.loads((tmp_path / "summary.json").read_text()))
    for variant in (bn.load(path, variant="lc low"), bn.load(path).variant("lc low")):
        assert figures_of(variant.run().summary) == expected
    with pytest.raises(bn.ConfigError, match="did you mean 'lc low'"):
        bn.load(path, variant="lc lo")


def test_tables_of_a_study_in_pandas_and_xarray(study):
    frame = study.to_pandas()
    variant, metric = next((v, m) for v in study for m in study[v])
    assert np.array_equal(frame.loc[variant][metric], study[variant][metric])
    assert frame.attrs["units"][metric] == study[variant].units[metric]
    dataset = study.to_xarray()
    assert dict(dataset.sizes) == {"variant": len(study), "run": 2}


def test_covariance(project, command, figures_of):
    analysis = bn.load(project / "configs" / "ship_motion" / "table1.json").covariance(budget=True)
    line = ("covariance", "configs/ship_motion/table1.json", "--budget")
    assert figures_of(dict(analysis)) == figures_of(command(*line, "--json", "--quiet"))
    assert str(analysis) == command(*line)


def test_smooth(project, command, figures_of):
    smoothed = bn.load(project / "configs" / "quickstart.json").smooth(seed=2)
    assert list(smoothed) == ["ins", "ins.smoothed"]
    printed = command("run", "configs/quickstart.json", "--smooth", "--seed", "2", "--json", "--quiet")
    assert figures_of(dict(smoothed.summary)) == figures_of(printed)
    assert smoothed["ins.smoothed"]["position"].sigma.mean() < smoothed["ins"]["position"].sigma.mean()


TUNED = {
    "/sources/drive/repeat": 1,
    "/tune/parameters": {"/filters/ins/measurements/fix/stack/position/scale": {}},
}


def test_tune(project, command, figures_of, tmp_path):
    line = [word for pointer, value in TUNED.items() for word in ("--set", f"{pointer}={json.dumps(value)}")]
    tuning = bn.load(project / "tests" / "tune" / "ins.json", set=TUNED).tune(jobs=2)
    printed = command("tune", "tests/tune/ins.json", *line, "--summary", tmp_path / "tune.json", status=(0, 1))
    written = (tmp_path / "tune.json").read_text()
    assert figures_of(dict(tuning)) == figures_of(written) and str(tuning) == printed
    assert tuning.patch == json.loads(written)["patch"]


def test_configs_that_are_tuned_over_are_those_of_their_files(project):
    """The text of parse() is of the config alone, and not of the configs that it names."""
    path = project / "tests" / "tune" / "ins.json"
    config = bn.load(path, set=TUNED).config
    config["tune"]["over"] = ["ins.json"]
    other = json.loads(json.dumps(config))
    other["sources"]["drive"]["gnss"]["position_sigma"] = "5 m"
    repeat = {"/sources/drive/repeat": 1}
    a, b = (bn.parse(each, name=path.with_name("mine.json"), set=repeat).tune() for each in (config, other))
    assert a["parameters"] == b["parameters"]


def test_observe(project, command, figures_of):
    observed = bn.load(project / "configs" / "quickstart.json").observe("0:40")
    line = ("observe", "configs/quickstart.json", "--window", "0:40")
    assert figures_of(dict(observed)) == figures_of(command(*line, "--json", "--quiet"))
    assert str(observed) == command(*line)
    with pytest.raises(ValueError, match="windows"):
        bn.load(project / "configs" / "quickstart.json").observe("no such window")


def test_allan(project, command, figures_of):
    path = project / "configs" / "quickstart.json"
    noise = bn.allan(path, "drive.imu")
    line = ("allan", "configs/quickstart.json", "--channel", "drive.imu")
    assert figures_of(dict(noise)) == figures_of(command(*line, "--json"))
    assert str(noise) == command(*line)
    assert str(bn.load(path).allan("drive.imu")) == str(noise)
    tau, deviation = noise.tau("wx"), noise.deviation("wx")
    assert tau.shape == deviation.shape and np.all(np.diff(tau) > 0) and np.all(deviation > 0)
    with pytest.raises(ValueError, match="did you mean 'drive.imu'"):
        bn.allan(path, "drive.imo")


def test_inspect(project, command, figures_of, tmp_path):
    path = project / "configs" / "quickstart.json"
    assert figures_of(dict(bn.inspect(path))) == figures_of(command("inspect", "configs/quickstart.json", "--json"))
    assert str(bn.inspect(bn.load(path))) == command("inspect", "configs/quickstart.json")
    bn.load(project / "configs" / "tutorial" / "data.json", vars={"folder": tmp_path}).run(records=False)
    files = sorted(tmp_path.glob("*.csv"))
    assert str(bn.inspect(*files)) == command("inspect", *files)


def stopped(call):
    """Seconds that it took to end after Ctrl-C, half a second after it began."""
    sent = []

    def send():
        sent.append(time.monotonic())
        signal.raise_signal(signal.SIGINT)

    timer = threading.Timer(0.5, send)
    try:
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            call()
    finally:
        timer.cancel()
    return time.monotonic() - sent[0]


@pytest.mark.parametrize(
    "call",
    [
        lambda p: bn.load(p / "configs" / "transfer_alignment" / "table3.json").study(runs=10_000, jobs=2),
        lambda p: bn.load(p / "configs" / "aiding" / "covariance.json", set={"/covariance/runs": 1000}).covariance(),
        lambda p: bn.load(p / "tests" / "tune" / "ins.json", set={"/sources/drive/repeat": 100}).tune(jobs=2),
        lambda p: bn.load(p / "configs" / "quickstart.json", set=LONG).observe(),
        lambda p: bn.load(p / "configs" / "quickstart.json", set=LONG).allan("drive.imu"),
        lambda p: bn.load(p / "configs" / "quickstart.json", set=LONG).smooth(),
    ],
    ids=["study", "covariance", "tune", "observe", "allan", "smooth"],
)
def test_ctrl_c_stops_it(project, call):
    assert stopped(lambda: call(project)) < 20


def test_other_threads_go_on_meanwhile(project):
    count, over = [0], threading.Event()

    def work():
        while not over.is_set():
            count[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=work)
    thread.start()
    bn.load(project / "configs" / "transfer_alignment" / "table3.json").study(runs=1, jobs=1)
    before = count[0]
    bn.load(project / "configs" / "quickstart.json").observe()
    over.set()
    thread.join()
    assert before > 20 and count[0] > before
