# SPDX-License-Identifier: Apache-2.0
"""What the system grants is short: memory, open files, threads, stack. Each ends with a message and a status, or with the results
that it has where nothing is short; none by a signal, and nothing is left half-written."""

import json
import os
import pathlib
import resource
import shutil
import subprocess
import tempfile

import pytest

from conftest import COMMAND
from drives import drive, study

MEMORY = "error: memory is exhausted; raise the limit (ulimit -v), or record less"
THREADS = "no thread can be started: Resource temporarily unavailable; raise the limit (ulimit -u, or -v of memory)"
SECONDS = 60


def limited(folder, words, limits, user=None):
    """Status and stderr of `binnacle WORDS` in the folder, under the limits, as a user of that number."""

    def begin():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for limit, value in limits.items():
            resource.setrlimit(limit, (value, value))
        if user is not None:
            os.setgroups([])
            os.setgid(user)
            os.setuid(user)

    with open(pathlib.Path(folder) / ".stderr", "w+") as err:  # one that takes no file of the command's own
        done = subprocess.run([COMMAND, *map(str, words)], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=err,
                              preexec_fn=begin, timeout=SECONDS)
        err.seek(0)
        return done.returncode, err.read()


def holds(folder, name):
    """Whether it has results of the run or study; else it has none at all, but for the journal that a study goes on from."""
    names = {path.name for path in (folder / "out").iterdir()} if (folder / "out").exists() else set()
    shutil.rmtree(folder / "out", ignore_errors=True)
    if name in names:
        return True
    assert names <= {"study.journal", "study.csv", "table.csv", "study.nc"}, names
    return False


@pytest.fixture(params=["run", "study"])
def words(request, write):
    write("c.json", drive(2000))
    write("s.json", study(8, 200))
    return {"run": ["run", "c.json", "--out", "out", "--quiet"], "study": ["study", "s.json", "--out", "out", "--quiet", "--jobs", 4]}[request.param]


def summary_of(words):
    return {"run": "summary.json", "study": "study.json"}[words[0]]


def test_memory(words, tmp_path):
    """From what takes the program alone to what is enough; MiB of address space."""
    said, enough = [], 0
    for mib in range(32, 480, 8):
        status, err = limited(tmp_path, words, {resource.RLIMIT_AS: mib << 20})
        if status == 127 and "error while loading shared libraries" in err:
            continue  # the system's loader, before the program
        assert status >= 0 and status in (0, 1, 3, 4, 5), f"{mib} MiB: status {status}: {err[:1000]}"
        whole = holds(tmp_path, summary_of(words))
        assert whole == (status == 0) or "report.html" in err, f"{mib} MiB: status {status}: {err[:1000]}"
        if status != 0:
            assert err.strip() and "internal" not in err and "terminate" not in err and "exit()" not in err, f"{mib} MiB: {err[:1000]}"
            said.append(err)
        enough += status == 0
    assert any(MEMORY in err for err in said), said
    assert enough > 3


def test_open_files(words, tmp_path):
    said, enough = [], 0
    for count in range(4, 24):
        status, err = limited(tmp_path, words, {resource.RLIMIT_NOFILE: count})
        if status == 127:
            continue
        assert status in (0, 2, 3, 4, 5), f"{count} files: status {status}: {err[:1000]}"
        holds(tmp_path, summary_of(words))
        if status != 0:
            assert "Too many open files" in err, f"{count} files: {err[:1000]}"
            said.append(err)
        enough += status == 0
    assert said and enough > 3


def test_threads():
    """Of another user, since root has no such limit: what cannot be without a thread says so, a study takes as many as it is given."""
    if os.getuid() != 0:
        pytest.skip("takes root, to become a user without processes")
    user = 54321  # nobody has it
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        os.chown(folder, user, user)
        (folder / "c.json").write_text(json.dumps(drive(500)))
        (folder / "s.json").write_text(json.dumps(study(8, 200)))
        status, err = limited(folder, ["check", "c.json"], {}, user)
        if status != 0:
            pytest.skip(f"another user cannot start {COMMAND}: {err[:200]}")
        ended = {}
        for verb, words in {"run": ["c.json", "--out", "out", "--only", "csv"], "study": ["s.json", "--jobs", "8", "--out", "out"]}.items():
            for count in range(0, 12):
                status, err = limited(folder, [verb, *words, "--quiet"], {resource.RLIMIT_NPROC: count}, user)
                assert status in (0, 1), f"{verb} with {count}: status {status}: {err}"
                whole = holds(folder, {"run": "summary.json", "study": "study.json"}[verb])
                assert whole == (status == 0)
                assert status == 0 or THREADS in err, f"{verb} with {count}: {err}"
                ended[verb, count] = status
        assert ended["run", 1] == 1 and ended["study", 1] == 1
        assert ended["run", 6] == 0 and ended["study", 4] == 0, ended


@pytest.mark.parametrize("kib", [256, 512, 1024])
def test_stack(words, tmp_path, write, kib):
    limits = {resource.RLIMIT_STACK: kib << 10}
    status, err = limited(tmp_path, words, limits)
    assert status == 0, err
    assert holds(tmp_path, summary_of(words))


def test_stack_of_objects_within_each_other(tmp_path, write):
    """As deep as may be, and deeper; of a chain of extends too, which takes the most: 2 MiB are enough, 8 are usual."""
    for depth, code in ((190, "B012"), (5000, "B001")):
        write("deep.json", '{"a":' * depth + "1" + "}" * depth)
        status, err = limited(tmp_path, ["check", "deep.json"], {resource.RLIMIT_STACK: 256 << 10})
        assert status == 3 and code in err, err[:1000]
    for i in range(99):
        tree = {"extends": f"c{i + 1}.json"}
        for _ in range(150):
            tree = {"a": tree}
        write(f"c{i}.json", tree)
    write("c99.json", drive())
    status, err = limited(tmp_path, ["check", "c0.json"], {resource.RLIMIT_STACK: 2 << 20})
    assert status == 3, f"{status}: {err[:1000]}"
