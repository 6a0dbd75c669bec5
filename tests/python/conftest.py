# SPDX-License-Identifier: Apache-2.0
"""What tests of the package share: where the project, its command and recorded data are."""

import json
import os
import pathlib
import subprocess

import pytest


@pytest.fixture(scope="session")
def project():
    return pathlib.Path(os.environ["BINNACLE_PROJECT"])


@pytest.fixture(scope="session")
def data(project):
    """Recorded data; a test that wants them is skipped where there are none."""
    folder = pathlib.Path(os.environ.get("BINNACLE_DATA", project / ".." / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no recorded data in {folder}")
    return folder


@pytest.fixture(scope="session")
def command(project):
    """Runs `binnacle ARGUMENTS` in the project's folder: what it printed."""

    def run(*arguments, status=(0,)):
        done = subprocess.run([os.environ["BINNACLE_COMMAND"], *map(str, arguments)], cwd=project, text=True, capture_output=True)
        assert done.returncode in status, done.stderr
        return done.stdout

    return run


def without_wall_time(summary):
    """The figures without times of the clock."""
    if isinstance(summary, dict):
        return {key: without_wall_time(value) for key, value in summary.items() if key not in ("wall_s", "filter_s")}
    if isinstance(summary, list):
        return [without_wall_time(value) for value in summary]
    return summary


@pytest.fixture(scope="session")
def figures_of():
    return lambda text_or_dict: without_wall_time(json.loads(text_or_dict) if isinstance(text_or_dict, str) else text_or_dict)


def pytest_sessionfinish(session, exitstatus):
    """A file with a test that could not run here is no pass: ctest shows it as skipped."""
    skipped = session.config.pluginmanager.get_plugin("terminalreporter").stats.get("skipped")
    if skipped and exitstatus in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
        session.exitstatus = 77
