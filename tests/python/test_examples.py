# SPDX-License-Identifier: Apache-2.0
"""sdk/examples/python: each script runs, and leaves a picture with something on it."""

import os
import re
import subprocess
import sys

import pytest

matplotlib = pytest.importorskip("matplotlib", reason="no matplotlib (Debian package python3-matplotlib)")
image = pytest.importorskip("matplotlib.image")

# The smallest sizes that still draw something.
SCRIPTS = {
    "quickstart.py": [],
    "compare_filters.py": [],
    "own_data.py": [],
    "own_model.py": [],
    "tuning.py": [],
    "monte_carlo.py": ["--runs", "20"],
}


def run(project, folder, script, *arguments):
    done = subprocess.run(
        [sys.executable, project / "sdk/examples/python" / script, *arguments],
        cwd=folder, text=True, capture_output=True, env={**os.environ, "MPLCONFIGDIR": str(folder)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_script_is_tried(project):
    there_are = {path.name for path in (project / "sdk/examples/python").glob("*.py")} - {"picture.py"}
    assert there_are == set(SCRIPTS)


@pytest.mark.parametrize("script", SCRIPTS)
def test_script_draws(project, tmp_path, script):
    picture = tmp_path / "picture.png"
    printed = run(project, tmp_path, script, "--picture", picture, *SCRIPTS[script])
    assert "picture.png is written" in printed
    assert "nan" not in printed.lower().split(), printed
    pixels = image.imread(picture)[..., :3]
    is_drawn = (pixels < 0.99).any(axis=-1)
    # Something in every quarter of it, and colours, which axes alone have not.
    rows, columns = is_drawn.shape
    for part in (is_drawn[: rows // 2], is_drawn[rows // 2 :]):
        for quarter in (part[:, : columns // 2], part[:, columns // 2 :]):
            assert quarter.mean() > 0.01
    assert (pixels.max(axis=-1) - pixels.min(axis=-1) > 0.2).mean() > 0.002


def rms_of(printed, name):
    return float(re.search(rf"^ *{re.escape(name)} +([0-9.]+)", printed, re.MULTILINE)[1])


def test_monte_carlo_finds_the_covariance_that_is_true(project, tmp_path):
    printed = run(project, tmp_path, "monte_carlo.py", "--picture", tmp_path / "picture.png", "--runs", "40")
    found = {kind: float(mean) for mean, kind in re.findall(r"state +of 9: mean NEES +([0-9.]+),.* if (.*)", printed)}
    # Of 40 runs, whose errors last for the whole run, the mean has a sigma of at most sqrt(2 * 9 / 40) = 0.67.
    assert abs(found["biases are constant"] - 9) < 3 * 0.67, printed
    assert found["biases drift"] < 9 - 3 * 0.67, printed


def test_own_data_are_filtered_as_if_all_had_been_known(project, tmp_path, command):
    printed = run(project, tmp_path, "own_data.py", "--picture", tmp_path / "picture.png")
    known = command("run", "configs/tutorial/drive.json", "--var", f"data={project / 'configs/tutorial'}")
    # What was found of the mounting is good to half a degree, as it states; position does not suffer.
    assert rms_of(printed, "position.horizontal") < 1.5 * rms_of(known, "position.horizontal")
    assert rms_of(printed, "attitude.yaw") < rms_of(known, "attitude.yaw") + 0.51


def test_own_model_is_consistent(project, tmp_path):
    printed = run(project, tmp_path, "own_model.py", "--picture", tmp_path / "picture.png", "--steps", "1000")
    assert "conformance: nothing found" in printed
    nees = float(re.search(r"^ *position +([0-9.]+) +2 +\d+$", printed, re.MULTILINE)[1])
    assert 1.7 < nees < 2.3, printed  # 2, with a sigma of sqrt(2 * 2 / 1000) = 0.063 if errors were white
