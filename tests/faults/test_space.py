# SPDX-License-Identifier: Apache-2.0
"""A disk that is full: exit status 5 with the file and the reason, nothing half-written, earlier results as they were."""

import json
import os
import subprocess

import pytest

from drives import copied, drive, study

FULL = "No space left on device"


@pytest.fixture
def disk(tmp_path):
    """Makes a file system of so many KiB in the test's folder."""
    place = tmp_path / "disk"
    mounted = []

    def disk(kib):
        place.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kib}k", "none", place], capture_output=True, text=True)
        if done.returncode:
            pytest.skip(f"no file system can be mounted, which takes root: {done.stderr.strip()}")
        mounted.append(place)
        return place

    yield disk
    for each in mounted:
        subprocess.run(["umount", "-l", each], check=True)


def fill(place, left):
    """Leaves so many bytes, in whole pages."""
    (place / "filler").unlink(missing_ok=True)
    free = os.statvfs(place).f_bavail * os.statvfs(place).f_frsize
    with open(place / "filler", "wb") as file:
        file.write(bytes(max(0, free - left)))


def files_in(folder):
    """All of them, hidden ones too, by name."""
    return {path.name: path.read_bytes() for path in folder.iterdir()} if folder.exists() else {}


@pytest.mark.parametrize("only", ["nc,csv,page", "nc", "csv", "page"])
def test_a_run_that_finds_no_room(binnacle, write, disk, only):
    """Wherever it ends: the data are those of the earlier run, or, where only the page found no room, all those of this one."""
    place = disk(4000)
    write("c.json", drive(1000))
    words = ["run", "c.json", "--out", "disk/out", "--only", only, "--quiet"]
    assert binnacle(*words, "--seed", 1).status == 0
    whole = sum(len(content) for content in files_in(place / "out").values())
    refused = 0
    for part in (0, 0.02, 0.1, 0.3, 0.6, 0.9, 1, 1.1):
        (place / "filler").unlink(missing_ok=True)
        assert binnacle(*words, "--seed", 1).status == 0
        before = files_in(place / "out")
        fill(place, int(part * whole))
        ended = binnacle(*words, "--seed", 2)
        after = files_in(place / "out")
        if ended.status == 0:
            assert after.keys() == before.keys() and after["summary.json"] != before["summary.json"]
            continue
        refused += 1
        ended.refused(5, "error: 'disk/out/", f"could not be written: {FULL}; make room there, or write elsewhere")
        if "report.html" in ended.err:
            assert "report.html" not in after
            assert json.loads(after["summary.json"])["seed"] == 2
            assert after.keys() == before.keys() - {"report.html"}
        else:
            assert after == before
    assert refused >= (0 if only == "page" else 4)  # an earlier page makes room for the next


@pytest.mark.parametrize("only", ["nc,csv,page", "nc", "csv", "page"])
def test_a_run_into_a_new_folder_leaves_none(binnacle, write, disk, only):
    """But for the page, which comes last: without it the data are whole all the same."""
    place = disk(40)
    write("c.json", drive(1000))
    binnacle("run", "c.json", "--out", "disk/deep/out", "--only", only).refused(5, "error: 'disk/deep/out/", FULL)
    if only == "page":
        assert files_in(place / "deep" / "out").keys() == {"config.json", "summary.json"}
    else:
        assert not files_in(place)


@pytest.fixture
def recorded(binnacle, write, tmp_path):
    """A recorded run in `out`, a table x.csv, and a config of it in t.json, all on a disk with room."""
    write("x.csv", "t,b\n" + "".join(f"{i},{i % 7}\n" for i in range(20000)))
    write("c.json", drive(1000))
    write("t.json", {"binnacle": 1, "sources": {"a": {"type": "csv", "path": "x.csv", "columns": {"z0": {"column": "b", "unit": "1"}}}},
                     "filters": {}})
    assert binnacle("run", "c.json", "--out", "out", "--quiet").status == 0


@pytest.mark.parametrize("words", [
    ["run", "c.json", "--quiet", "--summary"],
    ["study", "s.json", "--quiet", "--summary"],
    ["inspect", "x.csv", "--page"],
    ["inspect", "c.json", "--force", "--write"],
    ["report", "out", "--output"],
    ["report", "out", "out", "--output"],
    ["export", "out", "--to", "csv", "-o"],
    ["export", "out", "--to", "kml", "--origin", "48,11,500", "-o"],
    ["graph", "c.json", "--sparsity"],
], ids=lambda words: " ".join(word for word in words if word != "--quiet"))
def test_files_of_every_verb(binnacle, write, recorded, disk, words):
    place = disk(8)
    write("s.json", study(2, 200))
    (place / "file").write_text("earlier")
    fill(place, 0)
    before = files_in(place)
    ended = binnacle(*words, "disk/file")
    ended.refused(5, f"error: 'disk/file' could not be written: {FULL}; make room there, or write elsewhere")
    assert files_in(place) == before


def test_a_recorded_input(binnacle, write, disk, tmp_path):
    """It is written as samples come, so what had room is there, and is said to be not all."""
    place = disk(40)
    write("c.json", drive(1000))
    ended = binnacle("run", "c.json", "--quiet", "--out", "out", "--record-input", "disk/input")
    ended.refused(5, f"error: 'disk/input' has not all of the input: {FULL}")
    assert not (tmp_path / "out").exists()
    assert (place / "input").stat().st_size > 0


@pytest.mark.parametrize("kib", [0, 4, 8, 100])
def test_a_csv_sink(binnacle, write, disk, tmp_path, kib):
    place = disk(200)
    write("x.csv", "t,b\n" + "".join(f"{i},{i / 7}\n" for i in range(10000)))
    write("c.json", copied(place / "copy.csv"))
    (place / "copy.csv").write_text("earlier")
    fill(place, kib << 10)
    before = files_in(place)
    ended = binnacle("run", "c.json", "--out", "out", "--quiet")
    ended.refused(5, "B045", "/sinks/copy: plugin 'csv', component 'csv_writer': close at", f"'{place}/copy.csv' cannot be written: {FULL}")
    assert files_in(place) == before
    assert not (tmp_path / "out").exists()


def test_a_checkpoint_that_finds_no_room_leaves_the_last_one_that_did(binnacle, write, disk, tmp_path):
    place = disk(400)
    write("c.json", drive(4000))
    words = ["run", "c.json", "--only", "csv", "--quiet", "--out"]
    assert binnacle(*words, "whole").status == 0
    ended = binnacle(*words, "out", "--checkpoint", "disk/k@50s")
    ended.refused(5, "error: 'disk/k", f"could not be written: {FULL}; make room there, or write elsewhere")
    assert not (tmp_path / "out").exists()
    assert set(files_in(place)) == {"k", "k.records"}
    subprocess.run(["mount", "-o", "remount,size=4000k", place], check=True)
    assert binnacle(*words, "out", "--checkpoint", "disk/k@50s", "--resume", "disk/k").status == 0
    assert (tmp_path / "out" / "track.csv").read_bytes() == (tmp_path / "whole" / "track.csv").read_bytes()
    assert not files_in(place)


def test_a_study_that_finds_no_room_goes_on_when_there_is_some(binnacle, write, disk, tmp_path):
    place = disk(400)
    write("s.json", study(300, 100))
    words = ["study", "s.json", "--quiet", "--jobs", 2, "--out"]
    assert binnacle(*words, "whole").status == 0
    names = []
    for left in (0, 8 << 10, 24 << 10, 64 << 10):
        fill(place, left)
        ended = binnacle(*words, "disk/out")
        ended.refused(5, "error: 'disk/out", FULL, "; make room there, or write elsewhere")
        names.append(ended.err.split("'")[1])
        assert "study.json" not in files_in(place / "out")
        assert not [name for name in files_in(place / "out") if name.startswith(".")]
    assert "disk/out/study.journal" in names, names
    (place / "filler").unlink()
    subprocess.run(["mount", "-o", "remount,size=8000k", place], check=True)
    assert binnacle(*words, "disk/out").status == 0
    for name in ("study.csv", "table.csv", "study.json"):
        assert (place / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


@pytest.mark.parametrize("words", [
    ["--help"], ["run", "--help"], ["version"], ["list"], ["describe", "--all"], ["schema"],
    ["run", "c.json"], ["run", "c.json", "--json"], ["study", "s.json", "--json"], ["explain", "c.json"], ["graph", "c.json"],
    ["inspect", "x.csv"], ["observe", "c.json"],
], ids=" ".join)
def test_stdout_that_takes_nothing(command_into, write, words):
    write("c.json", drive(100))
    write("s.json", study(2, 100))
    write("x.csv", "t,b\n" + "".join(f"{i},{i % 7}\n" for i in range(100)))
    status, err = command_into("/dev/full", *words)
    assert status == 5, err
    assert f"error: stdout could not be written: {FULL}" in err


@pytest.fixture
def command_into(tmp_path):
    from conftest import COMMAND

    def command_into(path, *words):
        if not os.path.exists(path):
            pytest.skip(f"there is no {path}")
        with open(path, "wb") as out:
            done = subprocess.run([COMMAND, *words], cwd=tmp_path, stdout=out, stderr=subprocess.PIPE, text=True, timeout=60)
        return done.returncode, done.stderr

    return command_into
