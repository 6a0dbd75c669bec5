# SPDX-License-Identifier: Apache-2.0
"""Hostile data: files without end, labels and numbers without sense; each ends in the stated time, and nothing is lost unseen."""

import gzip
import json
import os

import pytest

DAY = 86400
YEAR = 365.25 * DAY


@pytest.fixture
def run(binnacle, write, tmp_path):
    """Runs a filter of one state over rows of t and b: how it ended, and its summary."""

    def run(lines, head="t,b\n", name="x.csv", end="\n", within=60, kind=None, measured=True, **source):
        if lines is not None:
            write(name, head + "\n".join(lines) + end)
        column = {"column": "b", "unit": "1"} | ({"kind": kind} if kind else {})
        measurement = {"type": "linear_measurement", "channel": "a", "blocks": {"x": "x"}, "sigma": [1]}
        write("c.json", {
            "binnacle": 1,
            "sources": {"a": {"type": "csv", "path": name, "columns": {"z0": column}} | source},
            "filters": {"f": {
                "trust": False,
                "blocks": {"x": {"type": "vector", "size": 1, "unit": "1", "init": 0, "sigma": 1}},
                "process": {"m": {"type": "random_constant", "blocks": {"x": "x"}}},
                "measurements": {"z": measurement} if measured else {},
            }},
        })
        ended = binnacle("run", "c.json", "--summary", "s.json", within=within)
        if ended.status == 0 and measured:
            ended.offered = json.loads((tmp_path / "s.json").read_text())["filters"]["f"]["measurements"]["z"]["offered"]
        return ended

    return run


def rows_at(labels):
    return [f"{label},1" for label in labels]


# ---- files without end


def newlines(path, head, tail, gib, line):
    """A gzip file of so much of one line."""
    piece = gzip.compress(line * ((64 << 20) // len(line)), 1)
    with open(path, "wb") as file:
        file.write(gzip.compress(head))
        for _ in range(gib * 16):
            file.write(piece)
        file.write(gzip.compress(tail))


@pytest.mark.parametrize("line", [b"\n", b"\r\n", b"  \t \n"], ids=["empty", "with a carriage return", "of blanks"])
def test_gibibytes_of_blank_lines(run, tmp_path, line):
    newlines(tmp_path / "x.csv.gz", b"t,b\n0,1\n", b"1,2\n", 1, line)
    ended = run(None, name="x.csv.gz", within=60)
    assert ended.status == 0, ended.err
    assert ended.offered == 2
    assert ended.work < 10, ended.work
    assert ended.peak < 200


def test_more_lines_than_an_int_counts(run, tmp_path):
    """4 GiB of newlines: lines behind the last that has a number are not told apart, and nothing overflows."""
    newlines(tmp_path / "x.csv.gz", b"t,b\n0,1\n", b"1,x\n", 4, b"\n")
    ended = run(None, name="x.csv.gz", within=60)
    ended.refused(5, "2147483647", "is not a number")
    assert ended.work < 25, ended.work


def test_nothing_but_newlines(run, tmp_path):
    newlines(tmp_path / "x.csv.gz", b"\n", b"\n", 1, b"\n")
    run(None, name="x.csv.gz", within=60).refused(5, "B066", "the file is empty")


@pytest.mark.parametrize("path", ["/dev/zero", "/dev/random", "/dev/tty"])
def test_devices(run, path):
    ended = run(None, name=path, within=10)
    assert ended.status == 5
    assert "regular file" in ended.err or "cannot be opened" in ended.err, ended.err


def test_a_line_without_end(run, tmp_path):
    with open(tmp_path / "x.csv", "wb") as file:
        file.write(b"t,b\n0,1\n")
        file.truncate(1 << 30)
    ended = run(None)
    ended.refused(5, "B061", "no line ends within 16 MiB")
    assert ended.peak < 200


# ---- labels


AHEAD = list(range(0, 50)) + [100_000] + list(range(50, 100))


def test_a_label_far_ahead_costs_one_row(run):
    ended = run(rows_at(AHEAD), invalid_rows="skip")
    assert ended.status == 0, ended.err
    assert ended.offered == 100
    assert "1 row skipped: time jumps ahead to 100000 s" in ended.err


def test_a_label_far_ahead_is_an_error_otherwise(run):
    run(rows_at(AHEAD)).refused(5, "B063", "x.csv:53")


def test_the_first_label_far_ahead(run):
    ended = run(rows_at([100_000] + list(range(0, 50))), invalid_rows="skip")
    assert ended.offered == 50
    assert "1 row skipped: time jumps ahead to 100000 s" in ended.err


def test_a_label_behind_the_window(run):
    ended = run(rows_at(AHEAD), invalid_rows="skip", window=["10 s", "90 s"])
    assert ended.offered == 81
    assert "1 row skipped: time jumps ahead to 100000 s" in ended.err


def test_the_window_ends_where_it_ends(run):
    ended = run(rows_at(list(range(0, 20)) + list(range(1000, 1100))), invalid_rows="skip", window=["0 s", "500 s"])
    assert ended.offered == 20
    assert "skipped" not in ended.err


def test_labels_that_go_back_once(run):
    ended = run(rows_at([0, 1, 2, 3, 1, 4, 5, 5, 6]), invalid_rows="skip")
    assert ended.offered == 7
    assert "2 rows skipped, the first: time does not increase: 1 s after 3 s" in ended.err


@pytest.mark.parametrize("label", ["4", "4,x", "3.99999"])
def test_a_file_of_rows_that_go_back(run, label):
    """Each is looked behind, and the file is read in linear time for all that."""
    ended = run(["0,1", "5,1"] + [f"{label},1"] * 1_000_000, invalid_rows="skip")
    assert ended.status == 0, ended.err
    assert ended.offered == 2
    assert "1000000 rows skipped" in ended.err
    assert ended.work < 10, ended.work


@pytest.mark.parametrize("place", range(0, 16))
def test_labels_far_ahead_wherever_blocks_end(run, place):
    """A block of one column is 10922 samples."""
    labels = list(range(0, 10915 + place)) + [10**6] + list(range(10915 + place, 33000))
    ended = run(rows_at(labels), invalid_rows="skip")
    assert ended.offered == 33000
    assert "1 row skipped: time jumps ahead to 1000000 s" in ended.err


def test_rows_of_one_sample_far_ahead(run):
    head = "t,b,k\n"
    rows = [f"{t},1,{k}" for t in AHEAD for k in (1, 2)]
    columns = {"z0": {"column": "b", "unit": "1"}, "key": {"column": "k", "unit": "1"}}
    ended = run(rows, head=head, invalid_rows="skip", columns=columns, rows={"key": "key"}, measured=False)
    assert "2 rows skipped, the first: time jumps ahead to 100000 s" in ended.err, ended.err


@pytest.mark.parametrize("years", [29.3, 140])
@pytest.mark.parametrize("kind", [None, "rate"])
def test_labels_decades_apart(run, years, kind):
    far = int(years * YEAR)
    ended = run(rows_at([0, far]), kind=kind)
    assert ended.status == 0, ended.err
    ended = run(rows_at([-far, 0, 1, far]), kind=kind)
    assert ended.status == 0, ended.err
    assert ended.offered == 4


@pytest.mark.parametrize("years", [147, 291, 293, 1e6])
def test_labels_centuries_from_zero(run, years):
    run(rows_at([0, int(years * YEAR)])).refused(5, "B062", "146 years")
    run(rows_at([-int(years * YEAR), 0])).refused(5, "B062", "146 years")


# ---- numbers


@pytest.mark.parametrize("number, value", [
    ("0." + "0" * 45 + "1", 1e-46),
    ("1" + "0" * 50, 1e50),
    ("0.1" + "0" * 60, 0.1),
    ("123456789" * 6 + "." + "123456789" * 6, 123456789123456789e36),
    ("0." + "0" * 400 + "1e400", 0.1),
    ("-0." + "0" * 330 + "1", 0),
    ("0." + "0" * 400, 0),
    ("1e-400", 0),
])
def test_numbers_of_many_digits(run, number, value):
    ended = run(["0,1", f"1,{number}"])
    assert ended.status == 0, ended.err


@pytest.mark.parametrize("number", ["9" * 330, "1e309", "-1" + "0" * 309 + ".5"])
def test_numbers_beyond_a_double(run, number):
    run(["0,1", f"1,{number}"]).refused(5, "B062", "beyond the range of a double")


@pytest.mark.parametrize("label", ["1." + "0" * 45 + "1", "0" * 45 + "1", "1" + "0" * 45 + "e-45", "0.9" + "9" * 60])
def test_labels_of_many_digits(run, label):
    ended = run(["0,1", f"{label},1", "2,1"])
    assert ended.status == 0, ended.err
    assert ended.offered == 3


def test_a_file_that_is_cut_within_its_last_number(run):
    ended = run(["0,1", "1,1", "2,12"], end="")
    assert ended.status == 0
    assert "B061" in ended.err and "x.csv:4" in ended.err and "the file and its last number may be truncated" in ended.err


@pytest.mark.parametrize("end", ["\n", "\r\n", "\n\n", "\n  "])
def test_a_file_that_is_not(run, end):
    assert "B061" not in run(["0,1", "1,1"], end=end).err
