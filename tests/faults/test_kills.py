# SPDX-License-Identifier: Apache-2.0
"""SIGKILL at any moment: what lies in the folder is whole, of one run or the other, and what was kept goes on to the same figures.

BINNACLE_KILLS=200 says how many of `run`; studies, runs with checkpoints and live runs get a quarter of it.
"""

import json
import os
import random
import signal
import subprocess
import time

import h5py

from drives import bearing, drive, live_drive, study

COMMAND = os.environ["BINNACLE_COMMAND"]
ROWS = 40001
KILLS = int(os.environ.get("BINNACLE_KILLS", "16"))
SEED = int(os.environ.get("BINNACLE_KILLS_SEED", "1"))
DRIVE = drive(40000)
STUDY = study(120)


def command(*words):
    return [COMMAND, *map(str, words)]


def finish(words, folder):
    done = subprocess.run(command(*words), cwd=folder, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr


def seconds_of(words, folder):
    begin = time.monotonic()
    finish(words, folder)
    return time.monotonic() - begin


def kill(words, folder, after):
    """Starts it and kills it after so many seconds; False: it was over before."""
    process = subprocess.Popen(command(*words), cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(after)
    process.send_signal(signal.SIGKILL)
    return process.wait() == -signal.SIGKILL


def moments(count, length):
    """Of all of the run, and as many of its end, where files get their names."""
    choose = random.Random(SEED)
    return [choose.uniform(0, length) if i % 2 == 0 else choose.uniform(0.85 * length, 1.1 * length) for i in range(count)]


def generation_of(folder, name):
    """Which seed's a file is; each is read whole."""
    if name == "run.nc":
        with h5py.File(folder / name) as file:
            assert file["track"]["time"].shape == (ROWS,)
            return int(file.attrs["seed"])
    if name == "track.csv":
        text = (folder / name).read_bytes()
        assert text.endswith(b"\n")
        return {hash(kept): seed for seed, kept in TABLES.items()}[hash(text)]
    if name == "summary.json":
        return json.loads((folder / name).read_text())["seed"]
    return None


TABLES = {}  # track.csv by its seed


def test_a_run_leaves_whole_files_of_one_run_or_the_other(tmp_path):
    (tmp_path / "c.json").write_text(json.dumps(DRIVE))
    words = {seed: ["run", "c.json", "--out", "out", "--only", "nc,csv", "--seed", seed, "--quiet"] for seed in (1, 2)}
    out = tmp_path / "out"
    for seed in (2, 1):
        length = seconds_of(words[seed], tmp_path)
        TABLES[seed] = (out / "track.csv").read_bytes()
    assert TABLES[1] != TABLES[2]
    killed = whole = 0
    for after in moments(KILLS, length):
        killed += kill(words[2], tmp_path, after)
        there = {path.name for path in out.iterdir() if not path.name.startswith(".")}
        found = {name: generation_of(out, name) for name in there - {"config.json"}}
        if "summary.json" in there:
            assert {"run.nc", "track.csv", "config.json"} <= there
            assert len(set(found.values())) == 1, found
            whole += 1
        finish(words[1], tmp_path)
        left = [path.name for path in out.iterdir() if path.name.startswith(".")]
        assert not left, f"left behind: {left}"
    print(f"{KILLS} kills, {killed} of a run under way, {whole} left all of one run")
    assert killed > KILLS / 4


def test_a_study_goes_on_to_the_same_figures(tmp_path):
    (tmp_path / "c.json").write_text(json.dumps(STUDY))
    words = ["study", "c.json", "--out", "again", "--quiet", "--jobs", "1"]
    length = seconds_of(words, tmp_path)
    words[3] = "whole"
    length = min(length, seconds_of(words, tmp_path))  # of a machine that has other work too
    table = (tmp_path / "whole" / "study.csv").read_bytes()
    killed = 0
    for i, after in enumerate(moments(max(4, KILLS // 4), length)):
        words[3] = f"out{i}"
        killed += kill(words, tmp_path, after)
        killed += kill(words, tmp_path, after / 2)
        finish(words, tmp_path)
        assert (tmp_path / words[3] / "study.csv").read_bytes() == table
    print(f"{max(4, KILLS // 4)} studies, {killed} kills of one under way")
    assert killed > 2


def test_a_run_with_checkpoints_goes_on_to_the_same_bits(tmp_path):
    (tmp_path / "c.json").write_text(json.dumps(DRIVE))
    plain = ["run", "c.json", "--out", "whole", "--only", "csv", "--quiet"]
    length = seconds_of(plain, tmp_path)
    table = (tmp_path / "whole" / "track.csv").read_bytes()
    killed = resumed = 0
    for i, after in enumerate(moments(max(4, KILLS // 4), length)):
        words = ["run", "c.json", "--out", f"out{i}", "--only", "csv", "--quiet", "--checkpoint", "k@1000s"]
        is_killed = kill(words, tmp_path, after)
        killed += is_killed
        if is_killed and (tmp_path / "k").exists():
            words += ["--resume", "k"]
            resumed += 1
        finish(words, tmp_path)
        assert (tmp_path / f"out{i}" / "track.csv").read_bytes() == table
        assert not (tmp_path / "k").exists()
    print(f"{max(4, KILLS // 4)} runs with checkpoints, {killed} killed under way, {resumed} went on from one")
    assert resumed > 0


LIVE_ROWS = 20000
PIPE = 2 * 65536  # bytes: what a pipe and its reader hold that the filter has not had yet


def feed(process, begin, end):
    """Gives the lines of these seconds to standard input; how far it came before the process was killed."""
    for t in range(begin, end):
        try:
            process.stdin.write(bearing(t).encode())
        except (BrokenPipeError, ValueError):
            return t
    return end


def times_of(table):
    return [float(line.split(b",", 1)[0]) for line in table.splitlines()[1:]]


def test_a_live_run_with_checkpoints_loses_only_what_came_after_the_last(tmp_path):
    (tmp_path / "c.json").write_text(json.dumps(live_drive()))
    every = 200
    words = ["run", "c.json", "--only", "csv", "--quiet", "--checkpoint", f"k@{every}s", "--out"]

    def start(out, *more):
        return subprocess.Popen(command(*words, out, *more), cwd=tmp_path, stdin=subprocess.PIPE,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    whole = start("whole")
    feed(whole, 0, LIVE_ROWS)
    _, said = whole.communicate()
    assert whole.returncode == 0, said
    lines = (tmp_path / "whole" / "track.csv").read_bytes().splitlines()
    assert len(lines) == LIVE_ROWS + 1
    waiting = PIPE // len(bearing(LIVE_ROWS))
    choose = random.Random(SEED)
    resumed = 0
    for i in range(max(4, KILLS // 4)):
        fed = choose.randrange(1, LIVE_ROWS)
        process = start(f"out{i}")
        feed(process, 0, fed)
        time.sleep(choose.uniform(0, 0.02))
        process.kill()
        process.communicate()
        assert process.returncode == -signal.SIGKILL
        assert not [path for path in (tmp_path / f"out{i}").glob("*") if not path.name.startswith(".")]
        if not (tmp_path / "k").exists():
            assert fed <= waiting + 1, "there was no checkpoint"
            continue
        resumed += 1
        process = start(f"out{i}", "--resume", "k")
        again = fed + 100  # what was sent meanwhile is lost
        feed(process, again, LIVE_ROWS + 200)
        _, said = process.communicate()
        assert process.returncode == 0, said
        table = (tmp_path / f"out{i}" / "track.csv").read_bytes()
        times = times_of(table)
        kept = sum(t < again for t in times)
        assert table.splitlines()[: kept + 1] == lines[: kept + 1], "what came before the checkpoint is not the same"
        assert kept >= fed - waiting - every, f"{fed} were fed, {kept} were kept"
        assert times[kept:] == list(range(again, LIVE_ROWS + 200))
        assert not (tmp_path / "k").exists()
    print(f"{max(4, KILLS // 4)} live runs killed, {resumed} went on from a checkpoint")
    assert resumed > 0
