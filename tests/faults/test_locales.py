# SPDX-License-Identifier: Apache-2.0
"""A locale with a decimal comma and points between thousands changes nothing that is read or written."""

import json
import os
import pathlib
import subprocess

import pytest

COMMAND = os.environ["BINNACLE_COMMAND"]
CONFIG = pathlib.Path(os.environ["BINNACLE_PROJECT"]) / "configs" / "quickstart.json"


@pytest.fixture(scope="module")
def german(tmp_path_factory):
    """The environment of a German user; the locale is made of what the Debian package locales has."""
    folder = tmp_path_factory.mktemp("locale")
    made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", str(folder / "de_DE.UTF-8")], capture_output=True, text=True)
    if not (folder / "de_DE.UTF-8").exists():
        pytest.skip(f"no German locale can be made (Debian package locales): {made.stderr.strip()[:200]}")
    environment = {**os.environ, "LOCPATH": str(folder), "LC_ALL": "de_DE.UTF-8"}
    point = subprocess.run(["locale", "decimal_point"], env=environment, capture_output=True, text=True).stdout.strip()
    assert point == ","
    return environment


def results_of(tmp_path, name, environment):
    out = tmp_path / name
    done = subprocess.run([COMMAND, "run", CONFIG, "--out", out, "--only", "csv", "--seed", "5"], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text = [line for line in done.stdout.splitlines() if " time" not in line and "per step" not in line and str(out) not in line]
    summary = json.loads((out / "summary.json").read_text())
    return text, (out / "ins.csv").read_bytes(), summary["filters"]["ins"]["reference"]


def test_a_run_is_the_same_in_german(tmp_path, german):
    plain = {**os.environ, "LC_ALL": "C"}
    assert results_of(tmp_path, "german", german) == results_of(tmp_path, "plain", plain)
