# SPDX-License-Identifier: Apache-2.0
"""Two processes that write the same files at one time, and results of two configs in one folder. BINNACLE_PAIRS=100 says how many pairs;
writers_test.cpp does as many of `run --out`."""

import json
import os
import shutil
import subprocess

import pytest

from conftest import COMMAND
from drives import copied, drive, study

PAIRS = int(os.environ.get("BINNACLE_PAIRS", "10"))
BUSY = " is writing there; wait until it ends, or give another --out"


def pair(folder, one, other):
    """Both at one time: how each ended."""
    begun = [subprocess.Popen([COMMAND, *map(str, words)], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for words in (one, other)]
    return [(process, process.communicate()[1]) for process in begun]


def hidden(folder):
    return sorted(path.name for path in folder.iterdir() if path.name.startswith(".") or ".part" in path.name or ".tmp" in path.name)


def test_pairs_of_studies_into_one_folder(write, tmp_path):
    """One of them does it; the other is refused with the name of the first, or comes when that is over and finds its journal."""
    write("s.json", study(6, 100))
    words = [["study", "s.json", "--out", "out", "--quiet", "--seed", seed] for seed in (3, 4)]
    whole = []
    for k, each in enumerate(words):
        subprocess.run([COMMAND, *map(str, each[:3]), f"whole{k}", *map(str, each[4:])], cwd=tmp_path, check=True)
        whole.append({name: (tmp_path / f"whole{k}" / name).read_bytes() for name in ("study.csv", "table.csv", "study.json")})
    assert whole[0] != whole[1]
    refused = 0
    for _ in range(PAIRS):
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
        statuses = []
        for process, err in pair(tmp_path, *words):
            statuses.append(process.returncode)
            assert process.returncode == 0 or process.returncode == 2 and (BUSY in err or "B092" in err), err
        assert sorted(statuses) == [0, 2]
        refused += 1
        left = {name: (tmp_path / "out" / name).read_bytes() for name in ("study.csv", "table.csv", "study.json")}
        assert left in whole
        assert not hidden(tmp_path / "out")
    print(f"{PAIRS} pairs of studies, {refused} refused")


def test_pairs_of_runs_with_one_csv_sink(write, tmp_path):
    """Sinks have no lock: the file is that of one or the other, whole."""
    write("short.csv", "t,b\n" + "".join(f"{i},1\n" for i in range(5000)))
    write("long.csv", "t,b\n" + "".join(f"{i},0.123456789\n" for i in range(50000)))
    for name in ("short", "long"):
        write(f"{name}.json", copied(tmp_path / "copy.csv", f"{name}.csv"))
        subprocess.run([COMMAND, "run", f"{name}.json", "--quiet"], cwd=tmp_path, check=True)
        (tmp_path / "copy.csv").rename(tmp_path / f"{name}.copy")
    whole = [(tmp_path / f"{name}.copy").read_bytes() for name in ("short", "long")]
    for _ in range(PAIRS):
        (tmp_path / "copy.csv").unlink(missing_ok=True)
        for process, err in pair(tmp_path, ["run", "short.json", "--quiet"], ["run", "long.json", "--quiet"]):
            assert process.returncode == 0, err
        assert (tmp_path / "copy.csv").read_bytes() in whole
        assert not hidden(tmp_path)
    print(f"{PAIRS} pairs of runs with one sink's file")


def test_a_csv_sink_leaves_the_temporary_of_another_alone(binnacle, write, tmp_path):
    write("x.csv", "t,b\n" + "".join(f"{i},1\n" for i in range(100)))
    write("c.json", copied(tmp_path / "copy.csv"))
    write("copy.csv.part", "another's")
    assert binnacle("run", "c.json", "--quiet").status == 0
    assert (tmp_path / "copy.csv.part").read_text() == "another's"
    assert (tmp_path / "copy.csv").read_text().startswith("t_s,")


# ---- one after the other, of two configs


@pytest.fixture
def configs(write):
    """study.json; same.json, its config; of the variant, calm.json; other.json, whose target is elsewhere."""
    varied = study(2, 100)
    varied["title"] = "Targets"
    varied["study"]["variants"] = {"base": {}, "calm": {"filters": {"track": {"process": {"wander": {"q": 0.01}}}}}}
    write("study.json", varied)
    other = drive(100)
    other["title"] = "Elsewhere"
    other["filters"]["track"]["process"]["wander"]["q"] = 0.5
    write("other.json", other)


def test_a_study_of_another_config_is_named_by_a_run(binnacle, configs):
    assert binnacle("study", "study.json", "--out", "out", "--quiet").status == 0
    ended = binnacle("run", "other.json", "--out", "out", "--quiet")
    assert ended.status == 0
    assert ended.err == ("note: 'out' also holds a study of another config, 'Targets', and its page shows both; remove study.nc and study.json there, "
                         "or give another --out\n")


def test_a_run_of_another_config_is_named_by_a_study(binnacle, configs):
    assert binnacle("run", "other.json", "--out", "out", "--quiet").status == 0
    ended = binnacle("study", "study.json", "--out", "out", "--quiet")
    assert ended.status == 0
    assert ended.err == ("note: 'out' also holds a run of another config, 'Elsewhere', and its page shows both; remove run.nc and summary.json there, "
                         "or give another --out\n")


@pytest.mark.parametrize("more", [[], ["--variant", "base"], ["--variant", "calm"], ["--seed", "7"]], ids=" ".join)
def test_a_run_of_the_study_itself_is_not(binnacle, configs, more):
    for _ in range(2):
        for words in (["study", "study.json"], ["run", "study.json", *more]):
            ended = binnacle(*words, "--out", "out", "--quiet")
            assert ended.status == 0 and ended.err == "", ended.err


def test_a_journal_of_another_config_is_refused(binnacle, configs, write, tmp_path):
    assert binnacle("study", "study.json", "--out", "out", "--quiet").status == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    changed = json.loads((tmp_path / "study.json").read_text())
    changed["filters"]["track"]["process"]["wander"]["q"] = 0.5
    write("changed.json", changed)
    binnacle("study", "changed.json", "--out", "out").refused(2, "B092", "another config, program or plugin; give another --out")
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


def test_the_tables_of_another_study_go_with_its_journal(binnacle, configs, write, tmp_path):
    """Where the journal is deleted to begin anew, nothing of the earlier study is left among the files of this one."""
    assert binnacle("study", "study.json", "--out", "out", "--quiet").status == 0
    (tmp_path / "out" / "study.journal").unlink()
    changed = json.loads((tmp_path / "study.json").read_text())
    changed["study"]["variants"] = {"lone": {}}
    write("changed.json", changed)
    for out in ("out", "new"):
        # One thread: the journal has the runs in the order in which they ended.
        assert binnacle("study", "changed.json", "--out", out, "--jobs", "1", "--quiet").status == 0
    for name in ("study.csv", "table.csv", "study.json", "study.journal"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "new" / name).read_bytes()
    assert {path.name for path in (tmp_path / "out").iterdir()} == {path.name for path in (tmp_path / "new").iterdir()}
