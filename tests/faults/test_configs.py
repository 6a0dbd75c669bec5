# SPDX-License-Identifier: Apache-2.0
"""Hostile configs: each ends in the stated time and memory, with a message that names what was found."""

import json
import os

import pytest

MANY = 100_000


def filter_of(blocks, process, measurements=None):
    return {"trust": False, "blocks": blocks, "process": process, "measurements": measurements or {}}


def vector(**more):
    return {"type": "vector", "size": 1, "unit": "1", "init": 0, "sigma": 1, **more}


def table(path, **more):
    """A source of one column, `b`."""
    return {"type": "csv", "path": path, "columns": {"z0": {"column": "b", "unit": "1"}}, **more}


def config(sources=None, **more):
    """A config that runs over x.csv, or over other sources."""
    measurement = {"type": "linear_measurement", "channel": "a", "blocks": {"x": "x"}, "sigma": [1]}
    constant = {"type": "random_constant", "blocks": {"x": "x"}}
    return {
        "binnacle": 1,
        "sources": sources or {"a": table("x.csv")},
        "filters": {"f": filter_of({"x": vector()}, {"m": constant}, {"z": measurement})},
        **more,
    }


ROWS = "t,b\n0,1\n1,2\n2,1\n"


@pytest.fixture
def bench(write):
    write("x.csv", ROWS)
    return write


# ---- crashes


def test_one_block_on_two_ports_that_advance_it(binnacle, bench):
    sway = {"type": "motion", "blocks": {"angle": "a", "rate": "a"}, "omega": [1.98], "zeta": [0.2], "sigma": 0.1}
    angle = {"type": "vector", "size": 1, "unit": "rad", "init": 0, "sigma": 1}
    bench("c.json", {"binnacle": 1, "filters": {"f": filter_of({"a": angle}, {"sway": sway})}})
    binnacle("check", "c.json").refused(3, "B019", "'a' is on two ports of 'sway'")


@pytest.mark.parametrize("zeta", [1e90, 1e100, 1e160, 1e300])
def test_a_sea_without_power(binnacle, bench, zeta):
    sea = {"significant_height": "5 m", "peak_period": "10 s", "response": {"omega": "1.2 rad/s", "zeta": zeta, "slope_gain": "0.8 rad"}}
    sway = {"type": "motion", "blocks": {"angle": "a", "rate": "b"}, "fit": {"order": 2, "sea": sea}}
    blocks = {"a": {"type": "vector", "size": 1, "unit": "rad", "init": 0, "sigma": 1}, "b": {"type": "vector", "size": 1, "unit": "rad/s", "init": 0, "sigma": 1}}
    bench("c.json", {"binnacle": 1, "filters": {"f": filter_of(blocks, {"sway": sway})}})
    ended = binnacle("check", "c.json")
    if zeta >= 1e100:
        ended.refused(3, "B030", "/fit")
    else:
        assert ended.status in (0, 3)


def test_a_chain_of_extends(binnacle, bench):
    for i in range(2500):
        bench(f"c{i}.json", {"extends": f"c{i + 1}.json"})
    bench("c2500.json", config())
    binnacle("check", "c0.json", within=15).refused(3, "B033", "a chain of more than 100 extends")
    assert binnacle("check", "c2402.json").status == 0


def test_extends_nested_deep_in_each_other(binnacle, bench):
    for i in range(99):
        tree = {"extends": f"c{i + 1}.json"}
        for _ in range(150):
            tree = {"a": tree}
        bench(f"c{i}.json", tree)
    bench("c99.json", config())
    binnacle("check", "c0.json", within=30).refused(3)


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (0, 1, 2)])
def test_closed_streams(binnacle, bench, tmp_path, closed):
    bench("c.json", config())
    ended = binnacle("run", "c.json", "--out", "out", "--summary", "s.json", closed=closed)
    assert ended.status == (5 if 1 in closed else 0)  # what stdout did not take is an error
    assert json.loads((tmp_path / "s.json").read_text())["filters"]
    for name in ("summary.json", "config.json"):
        json.loads((tmp_path / "out" / name).read_text())  # nothing else was written into a result


def test_closed_streams_with_an_error(binnacle, bench):
    bench("c.json", "{")
    assert binnacle("check", "c.json", closed=(0, 1, 2)).status == 3


def test_a_variance_below_zero_by_rounding(binnacle, bench):
    """1 - 0.419·K is zero but for the last bit, and of a variance of 0.22 ± 3e-17 is left."""
    c = config()
    c["filters"]["f"]["blocks"]["x"]["sigma"] = 0.47298206695519485
    c["filters"]["f"]["measurements"]["z"] |= {"H": [[0.419]], "sigma": [1e-20]}
    bench("c.json", c)
    ended = binnacle("run", "c.json")
    assert ended.status == 0, ended.err
    assert "below zero by rounding" in ended.err


# ---- inputs without end


def test_extends_of_a_device(binnacle, bench):
    bench("c.json", {"extends": "/dev/zero"})
    binnacle("check", "c.json", within=10).refused(3, "B003", "not a regular file")


def test_extends_of_a_fifo(binnacle, bench, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    bench("c.json", {"extends": "pipe"})
    binnacle("check", "c.json", within=10).refused(3, "B003", "not a regular file")


def test_a_config_without_end(binnacle, bench):
    binnacle("check", "/dev/zero", within=15).refused(3, "B033", "more than 16 MiB")


def test_a_config_through_a_pipe(binnacle, bench, tmp_path):
    read, written = os.pipe()
    os.write(written, json.dumps(config({"a": table(str(tmp_path / "x.csv"))})).encode())
    os.close(written)
    ended = binnacle("check", "/dev/stdin", stdin=read)
    os.close(read)
    assert ended.status == 0, ended.err


def test_a_config_that_nobody_writes_ends_with_sigterm(binnacle, bench, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert binnacle("check", "pipe", asked=0.5, within=15).status != 0


@pytest.mark.parametrize("source", [
    table("pipe"),
    {"type": "nmea", "path": "pipe"},
    {"type": "ublox", "path": "pipe"},
    {"type": "rtklib_pos", "path": "pipe"},
    {"type": "rinex", "observations": "pipe", "navigation": "pipe"},
    {"type": "oxts", "path": "pipe"},
], ids=lambda source: source["type"])
def test_sources_of_a_fifo(binnacle, bench, tmp_path, source):
    os.mkfifo(tmp_path / "pipe")
    c = config({"a": source})
    c["filters"]["f"]["measurements"] = {}
    bench("c.json", c)
    wanted = "holds no timestamps.txt" if source["type"] == "oxts" else "is not a regular file"
    binnacle("run", "c.json", within=10).refused(5, "B060", wanted)


def test_a_summary_into_a_fifo_that_nobody_reads(binnacle, bench, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    bench("c.json", config())
    binnacle("run", "c.json", "--summary", "pipe", within=15).refused(2, "FIFO without a reader")


def test_a_summary_into_a_fifo_whose_reader_does_not_read(binnacle, bench, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    c = config()
    for i in range(400):  # a summary beyond the 64 KiB of a pipe
        c["filters"]["f"]["measurements"][f"z{i}"] = c["filters"]["f"]["measurements"]["z"]
    bench("c.json", c)
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    try:
        binnacle("run", "c.json", "--summary", "pipe", "--quiet", asked=3, within=20).refused(5, "its reader does not read")
    finally:
        os.close(reader)


def test_variables_that_multiply(binnacle, bench):
    variables = {"v0": "x" * 10} | {f"v{i}": "".join("${v%d}" % (i - 1) for _ in range(10)) for i in range(1, 9)}
    bench("c.json", config(vars=variables, title="${v8}"))
    ended = binnacle("check", "c.json", within=15, memory=1024)
    ended.refused(3, "B033", "16 MiB")


def test_a_chain_of_variables(binnacle, bench):
    chain = {f"v{i}": "${v%d}" % (i - 1) for i in range(MANY - 1, 0, -1)} | {"v0": "x"}
    bench("c.json", config(vars=chain, title="${v%d}" % (MANY - 1)))
    binnacle("check", "c.json", within=30).refused(3, "B033", "a chain of more than 100 variables")


def test_unknown_variables(binnacle, bench):
    bench("c.json", config(vars={f"v{i}": i for i in range(MANY)}, description=["${w%d}" % i for i in range(MANY)]))
    binnacle("check", "c.json", within=30).refused(3, "B005")


LARGE = {f"k{i}": i for i in range(MANY)}


@pytest.mark.parametrize("name, content", [
    ("at the top", config() | LARGE),
    ("variables", config(vars=LARGE)),
    ("sources", config({f"k{i}": table("x.csv") for i in range(MANY)})),
    ("columns", config({"a": table("x.csv") | {"columns": {f"k{i}": {"column": "b", "unit": "1"} for i in range(MANY)}}})),
    ("blocks", {"binnacle": 1, "filters": {"f": filter_of({f"k{i}": vector() for i in range(MANY)}, {})}}),
    ("of extends", {"extends": "large.json"} | LARGE),
    ("deleted", {"extends": "large.json"} | {key: None for key in LARGE}),
])
def test_large_objects(binnacle, bench, name, content):
    bench("large.json", config() | LARGE)
    bench("c.json", content)
    ended = binnacle("check", "c.json", within=30, memory=2048)
    assert ended.status in (0, 3, 5), ended.err[:1000]
    assert ended.peak < 1024


def test_large_objects_take_linear_time(binnacle, bench):
    work = {}
    for count in (50_000, 200_000):
        bench("c.json", config(vars={f"k{i}": i for i in range(count)}))
        work[count] = min(binnacle("check", "c.json").work for _ in range(2))
    assert work[200_000] < 8 * work[50_000], work


def test_duplicates(binnacle, bench):
    bench("c.json", "{" + ",".join(f'"k{i % 50000}": {i}' for i in range(MANY)) + "}")
    binnacle("check", "c.json", within=30).refused(3, "B002")


def test_too_many_values(binnacle, bench):
    bench("c.json", config(description=[1] * 1_000_000))
    ended = binnacle("check", "c.json", within=30)
    ended.refused(3, "B033", "more than 500000 values")
    assert ended.peak < 1024


def test_as_many_values_as_there_may_be(binnacle, bench):
    bench("c.json", config(description=[1] * 450_000))
    ended = binnacle("check", "c.json", within=30)
    assert "B033" not in ended.err
    assert ended.peak < 1024, ended.peak


def test_long_keys(binnacle, bench):
    bench("c.json", {"k" * 1_000_000: [1] * 10_000})
    ended = binnacle("check", "c.json", within=30, memory=1024)
    ended.refused(3, "B033", "keys are too long")


def test_a_misspelt_key_of_a_million_letters(binnacle, bench):
    bench("c.json", {"filter" * 1_000_000: 1})
    binnacle("check", "c.json", within=30).refused(3, "B012")


def test_long_lists_of_extends(binnacle, bench):
    bench("e.json", config())
    bench("c.json", {"extends": ["e.json"] * MANY})
    binnacle("check", "c.json", within=30).refused(3, "B033", "more than 10000 extends")


def test_objects_that_double_themselves(binnacle, bench):
    levels = {"l0": {"v": 1}} | {f"l{i}": {side: {"extends": f"#/l{i - 1}"} for side in "ab"} for i in range(1, 60)}
    bench("c.json", levels)
    binnacle("check", "c.json", within=30, memory=2048).refused(3, "B033")


def test_too_many_states(binnacle, bench):
    blocks = {f"b{i}": vector(size=64) for i in range(40)}
    bench("c.json", {"binnacle": 1, "filters": {"f": filter_of(blocks, {f"m{i}": {"type": "random_constant", "blocks": {"x": f"b{i}"}} for i in range(40)})}})
    binnacle("check", "c.json", within=30).refused(3, "B033", "2560 error states")


# ---- accepted without sense


@pytest.mark.parametrize("more, code, words", [
    ({"record": {"every": -1}}, "B009", "'every' is a time of at least 0 s"),
    ({"record": {"every": "-1 s"}}, "B009", "'every' is a time of at least 0 s"),
    ({"evaluate": {"after": "10 s", "until": "5 s"}}, "B024", "'until' is not later than 'after'"),
    ({"evaluate": {"after": "start+10 s", "until": "start+10 s"}}, "B024", "'until' is not later than 'after'"),
    ({"evaluate": {"after": "200 a"}}, "B024", "not a time"),
    ({"evaluate": {"after": 5e9}}, "B024", "beyond 146 years"),
])
def test_sections_without_sense(binnacle, bench, more, code, words):
    bench("c.json", config(**more))
    binnacle("check", "c.json").refused(3, code, words)


@pytest.mark.parametrize("place, value, code, words", [
    ("filters/f", {"history": "1e20 s"}, "B008", "beyond 146 years"),
    ("filters/f", {"history": 1e20}, "B009", "beyond 146 years"),
    ("filters/f", {"trust": {"silent": 1e300}}, "B009", "beyond 146 years"),
    ("sources/a", {"latency": {"batch": "1e10 s"}}, "B009", "<= 1e+09"),
])
def test_durations_beyond_all_times(binnacle, bench, place, value, code, words):
    c = config()
    at = c
    for key in place.split("/"):
        at = at[key]
    at |= value
    bench("c.json", c)
    binnacle("check", "c.json").refused(3, code, words)


def test_a_negative_age(binnacle, bench):
    c = config()
    c["filters"]["f"]["blocks"]["x"] |= {"init": {"channel": "a", "fields": {"x": "z0"}, "max_age": "-1 s"}}
    bench("c.json", c)
    binnacle("check", "c.json").refused(3, "B009", "'max_age' is a time of at least 0 s")


def test_a_measurement_that_is_withheld_every_time(binnacle, bench):
    c = config()
    c["filters"]["f"]["measurements"]["z"] |= {"withhold": {"every": 1}}
    bench("c.json", c)
    ended = binnacle("check", "c.json")
    assert ended.status == 0 and "B031" in ended.err and "never uses 'z'" in ended.err, ended.err
