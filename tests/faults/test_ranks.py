# SPDX-License-Identifier: Apache-2.0
"""Ranks of an MPI study of which one is alive and does not come to work: after ten times the time-out the others name it.

tests/sdk/mpi_test.cpp stops and kills ranks; here a plugin's call does not come back while a rank reads its study."""

import os
import shutil
import subprocess
import time

import pytest

from conftest import COMMAND

SICK = os.environ.get("BINNACLE_SICK_PLUGIN", "")


@pytest.fixture
def mpirun(write, tmp_path):
    """Runs a study on two ranks; in the constructor of its source the rank loops."""
    module = os.path.join(os.path.dirname(os.path.realpath(COMMAND)), "../lib/binnacle/mpi/binnacle_mpi.so")
    if not shutil.which("mpirun") or not os.path.exists(module):
        pytest.skip("no MPI (Debian packages libopenmpi-dev, openmpi-bin)")
    assert os.path.exists(SICK), "BINNACLE_SICK_PLUGIN is the library of tests/faults/plugins/sick.cpp"

    def mpirun(rank, timeout):
        tick = {"type": "ticking", "fault": "loop", "call": "constructor", "rank": str(rank)}
        write("c.json", {
            "binnacle": 1,
            "plugins": [SICK],
            "sources": {"tick": tick},
            "filters": {"f": {
                "trust": False,
                "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
                "process": {"move": {"type": "moving", "blocks": {"x": "x"}}},
                "measurements": {"z": {"type": "linear_measurement", "channel": "tick", "blocks": {"x": "x"}, "sigma": [1]}}}},
            "reference": [{"channel": "tick", "blocks": {"f/x": ["z0"]}}],
            "study": {"runs": 4, "metrics": ["f/z/nis"]}})
        environment = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "BINNACLE_MPI_TIMEOUT": str(timeout)}
        begin = time.monotonic()
        done = subprocess.run(["mpirun", "--oversubscribe", "-n", "2", COMMAND, "study", "c.json", "--out", "out", "--jobs", "1", "--allow-plugins"],
                              cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=180)
        return done.returncode, done.stderr, time.monotonic() - begin

    return mpirun


def test_no_rank_has_the_fault(mpirun):
    status, err, _ = mpirun(7, 2)
    assert status == 0, err


@pytest.mark.parametrize("rank", [1, 0])
def test_a_rank_that_reads_its_study_for_ever(mpirun, tmp_path, rank):
    status, err, seconds = mpirun(rank, 2)
    assert status == 1, err
    assert f"rank {rank}" in err and "it is alive, but is still reading its study" in err and "a plugin's call may not come back" in err, err
    assert seconds < 120  # 10 or 20 times the time-out, and what the others on the machine make of it
    assert not (tmp_path / "out" / "study.csv").exists()
