# SPDX-License-Identifier: Apache-2.0
"""load, parse and run, against the command."""

import re
import signal
import threading
import time

import binnacle as bn
import numpy as np
import pytest


@pytest.fixture(scope="module")
def quickstart(project):
    return bn.load(project / "configs" / "quickstart.json")


def test_figures_are_those_of_the_command(project, command, figures_of, quickstart):
    result = quickstart.run()
    assert figures_of(dict(result.summary)) == figures_of(command("run", "configs/quickstart.json", "--json", "--quiet"))


def test_text_of_the_summary_is_what_the_command_prints(command, quickstart):
    def lines(text):
        without_times = re.sub(r"[0-9.]+ [mu]?s per step|wall time .*", "", text)
        return without_times.rstrip().splitlines()

    assert lines(str(quickstart.run().summary)) == lines(command("run", "configs/quickstart.json"))


def test_estimates_are_arrays_with_time_sigma_and_units(quickstart):
    filter = next(iter(quickstart.run().values()))
    position = filter["position"]
    assert position.shape == (len(position.t), 3) == position.sigma.shape
    assert position.names == ["lat", "lon", "height"] and position.units == ["rad", "rad", "m"]
    assert np.array_equal(filter["position.lat"], position[:, 0])
    assert np.array_equal(filter["position.lat"].sigma, position.sigma[:, 0])
    assert type(position[:3]) is np.ndarray and type(position + 1) is np.ndarray


def test_a_name_that_is_not_there_is_told_with_those_that_are(quickstart):
    result = quickstart.run()
    with pytest.raises(KeyError, match="there is no filter 'nobody'"):
        result["nobody"]
    with pytest.raises(KeyError, match="there is no block 'x'; there are"):
        next(iter(result.values()))["x"]


def test_errors_carry_their_diagnostics(project):
    with pytest.raises(bn.ConfigError) as caught:
        bn.parse({"binnacle": 1, "filtres": {}}, name=str(project / "configs" / "mine.json"))
    assert [d.code for d in caught.value.diagnostics if d.severity == "error"]
    assert any("filters" in d.message for d in caught.value.diagnostics)
    with pytest.raises(bn.ConfigError) as caught:
        bn.load(project / "configs" / "no_such.json")
    assert "no_such.json" in str(caught.value)


def test_a_dict_is_the_config(project, figures_of, quickstart):
    path = project / "configs" / "quickstart.json"
    parsed = bn.parse(quickstart.config, name=path)
    assert figures_of(dict(parsed.run(seed=3).summary)) == figures_of(dict(quickstart.run(seed=3).summary))


def test_settings_are_those_of_the_command(project, command, figures_of):
    pointer = "/filters/ins/measurements/fix/gate"
    set_here = bn.load(project / "configs" / "quickstart.json", set={pointer: 0.5}).run()
    printed = command("run", project / "configs/quickstart.json", "--json", "--quiet", "--set", f"{pointer}=0.5", status=(1,))  # a gate so tight loses it
    assert figures_of(dict(set_here.summary)) == figures_of(printed)
    assert not set_here["ins"].innovations["fix"].accepted.all()


@pytest.mark.parametrize("value", [-1, 1.5, True, "1"])
def test_a_seed_that_is_none_is_told_as_such(project, value):
    config = bn.load(project / "configs" / "quickstart.json")
    for name in ("seed", "run"):
        for call in (config.run, config.session, config.observe):
            with pytest.raises(ValueError, match=f"{name} is {value!r}: expected a whole number from 0 up"):
                call(**{name: value})


def test_ctrl_c_stops_a_run(project):
    composition = bn.load(project / "configs" / "quickstart.json")
    stop = threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT))
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        stop.start()
        for seed in range(10_000):
            composition.run(seed=seed)
    assert time.monotonic() - begin < 30
