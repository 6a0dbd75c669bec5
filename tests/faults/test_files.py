# SPDX-License-Identifier: Apache-2.0
"""Files that are none: FIFOs in the place of results and data, devices in the place of a csv; verbs that only look write nothing."""

import json
import os

import pytest

from drives import copied, drive, study

ROWS = "t,b\n" + "".join(f"{i},{i % 3}\n" for i in range(100))


@pytest.mark.parametrize("name", ["run.nc", "summary.json", "study.nc"])
def test_a_report_of_a_fifo(binnacle, write, tmp_path, name):
    write("c.json", drive(100))
    assert binnacle("run", "c.json", "--out", "out", "--quiet").status == 0
    (tmp_path / "out" / name).unlink(missing_ok=True)
    os.mkfifo(tmp_path / "out" / name)
    binnacle("report", "out", within=15).refused(5, f"'out/{name}'", "is not a regular file")


@pytest.mark.parametrize("words, file, status", [
    (["run", "c.json", "--resume", "pipe"], "pipe", 2),
    (["study", "s.json", "--out", "out"], "out/study.journal", 2),
], ids=lambda words: str(words))
def test_a_fifo_in_the_place_of_what_a_run_goes_on_from(binnacle, write, tmp_path, words, file, status):
    write("c.json", drive(100))
    write("s.json", study(2, 100))
    (tmp_path / "out").mkdir()
    os.mkfifo(tmp_path / file)
    binnacle(*words, within=15).refused(status, file, "is not a regular file")


def test_a_report_of_a_fifo_for_a_folder(binnacle, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    binnacle("report", "pipe", within=15).refused(5, "'pipe' is not a folder")


@pytest.mark.parametrize("words", [["report", "out", "--output"], ["inspect", "x.csv", "--page"], ["inspect", "c.json", "--write"]], ids=" ".join)
def test_a_page_into_a_fifo_that_nobody_reads(binnacle, write, tmp_path, words):
    write("c.json", drive(100))
    write("x.csv", ROWS)
    assert binnacle("run", "c.json", "--out", "out", "--quiet").status == 0
    os.mkfifo(tmp_path / "pipe")
    binnacle(*words, "pipe", within=15).refused(2, "'pipe'", "FIFO without a reader")


@pytest.mark.parametrize("name", ["pipe", "pipe.csv", "pipe.ubx", "pipe.nmea", "pipe.pos", "pipe.gz"])
def test_inspect_of_a_fifo(binnacle, tmp_path, name):
    os.mkfifo(tmp_path / name)
    binnacle("inspect", name, within=15).refused(5, name, "is not a regular file")


def test_inspect_of_a_fifo_in_the_place_of_a_config(binnacle, tmp_path):
    """A config may come through a pipe; the wait for it ends with a signal."""
    os.mkfifo(tmp_path / "pipe.json")
    assert binnacle("inspect", "pipe.json", asked=0.5, within=15).status != 0


@pytest.mark.parametrize("verb", ["check", "explain", "graph"])
def test_verbs_that_look_open_no_sink(binnacle, write, tmp_path, verb):
    config = copied(tmp_path / "copy.csv")
    config["sinks"]["lines"] = {"type": "stream/json_writer", "input": "gyro", "to": f"file:{tmp_path}/lines.json"}
    write("x.csv", ROWS)
    write("c.json", config)
    before = {path.name for path in tmp_path.iterdir()} | {".stdout", ".stderr"}
    ended = binnacle(verb, "c.json")
    assert ended.status == 0, ended.err
    assert {path.name for path in tmp_path.iterdir()} == before
    assert binnacle("run", "c.json", "--quiet").status == 0  # which does
    assert {path.name for path in tmp_path.iterdir()} == before | {"copy.csv", "lines.json"}


def test_a_csv_sink_does_not_replace_a_fifo(binnacle, write, tmp_path):
    write("x.csv", ROWS)
    os.mkfifo(tmp_path / "pipe")
    write("c.json", copied(tmp_path / "pipe"))
    binnacle("run", "c.json", within=15).refused(5, f"'csv_writer': open threw: '{tmp_path}/pipe' is not a regular file")
    assert (tmp_path / "pipe").is_fifo()


@pytest.mark.parametrize("labels", [
    [0, 1, 2, 100_000, 100_001, 3, 4, 5],
    [0, 1, 2, 100_000, 200_000, 3, 4, 5],
    [0, 1, 2, 200_000, 100_000, 3, 4, 5],
    [100_000, 100_001, 0, 1, 2, 3],
])
def test_two_labels_far_ahead_in_a_row(binnacle, write, tmp_path, labels):
    """Either both are passed over, or the rows that they cost are reported: none is lost unseen."""
    write("x.csv", "t,b\n" + "".join(f"{t},1\n" for t in labels))
    write("c.json", {
        "binnacle": 1,
        "sources": {"a": {"type": "csv", "path": "x.csv", "columns": {"z0": {"column": "b", "unit": "1"}}, "invalid_rows": "skip"}},
        "filters": {"f": {
            "trust": False,
            "blocks": {"x": {"type": "vector", "size": 1, "unit": "1", "init": 0, "sigma": 1}},
            "process": {"m": {"type": "random_constant", "blocks": {"x": "x"}}},
            "measurements": {"z": {"type": "linear_measurement", "channel": "a", "blocks": {"x": "x"}, "sigma": [1]}}}}})
    ended = binnacle("run", "c.json", "--summary", "s.json")
    assert ended.status == 0, ended.err
    offered = json.loads((tmp_path / "s.json").read_text())["filters"]["f"]["measurements"]["z"]["offered"]
    reported = sum(int(word) for line in ended.err.splitlines() if "skipped" in line
               for word, after in zip(line.split(), line.split()[1:]) if after in ("row", "rows"))
    assert offered + reported == len(labels), ended.err
