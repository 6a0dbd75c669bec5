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


def test_monte_carlo_finds_a_true_covariance(project, tmp_path):
    printed = run(project, tmp_path, "monte_carlo.py", "--picture", tmp_path / "picture.png", "--runs", "60")
    means = {block: float(mean) for block, mean in re.findall(r"(\w+) +mean NEES ([0-9.]+) of 3", printed)}
    assert set(means) == {"position", "velocity", "attitude"}
    assert all(2 < mean < 4 for mean in means.values()), printed
