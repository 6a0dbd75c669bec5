# SPDX-License-Identifier: Apache-2.0
"""sdk/python/show.sh, by which sdk/run lets `import binnacle` find the build: what it writes, and where it can write nothing."""

import os
import pathlib
import subprocess
import sys
import sysconfig

import binnacle as bn
import pytest

PACKAGE = pathlib.Path(bn.__file__).parent.parent
PROGRAM = "import binnacle; print(binnacle.load('configs/quickstart.json').run().summary)"


@pytest.fixture
def home(tmp_path):
    """A home where `python3` is the one that runs the tests."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "python3").symlink_to(sys.executable)
    return tmp_path


def environment(home, **more):
    left_out = ("PYTHONPATH", "PYTHONNOUSERSITE", "PYTHONUSERBASE", "BINNACLE_PLUGIN_PATH")
    kept = {name: value for name, value in os.environ.items() if name not in left_out}
    return {**kept, "HOME": str(home), "PATH": f"{home / 'bin'}:/usr/bin:/bin", **more}


def show(project, home, package=PACKAGE, **more):
    """What it printed; it never fails."""
    done = subprocess.run(["bash", project / "sdk/python/show.sh", package], env=environment(home, **more), capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    return done.stderr


def file_of(home):
    return home / f".local/lib/python3.{sys.version_info.minor}/site-packages/binnacle.pth"


def test_import_works_after_it_and_it_is_told_once(project, home, command):
    before = subprocess.run(["python3", "-c", "import binnacle"], env=environment(home), capture_output=True, text=True)
    assert "No module named 'binnacle'" in before.stderr
    assert str(file_of(home)) in show(project, home)
    assert file_of(home).read_text() == f"{PACKAGE}\n"
    assert show(project, home) == ""
    done = subprocess.run(["python3", "-B", "-c", PROGRAM], env=environment(home), cwd=project, capture_output=True, text=True)
    assert "verdict: ins ok" in done.stdout, done.stderr


def test_another_clone_gives_way_and_is_named(project, home):
    file_of(home).parent.mkdir(parents=True)
    file_of(home).write_text("/somewhere/else/build/release/python\n")
    assert "which was for /somewhere/else/build/release/python" in show(project, home)
    assert file_of(home).read_text() == f"{PACKAGE}\n"


def test_where_nothing_can_be_written_it_states_what_to_type(project, home):
    (home / ".local").write_text("no folder")
    printed = show(project, home)
    assert "cannot write" in printed and f"export PYTHONPATH={PACKAGE}" in printed


def test_where_packages_of_the_user_are_off_it_states_what_to_type(project, home):
    assert f"export PYTHONPATH={PACKAGE}" in show(project, home, PYTHONNOUSERSITE="1")
    assert not file_of(home).exists()


def pretend(home, script):
    """Another `python3`."""
    other = home / "bin" / "python3"
    other.unlink()
    other.write_text("#!/bin/sh\ncase $1 in " + script + " esac\n")
    other.chmod(0o755)


def test_a_python_of_another_version_is_named(project, home):
    pretend(home, "-c) echo .cpython-399-none.so;; --version) echo Python 3.99.0;;")
    assert "Python 3.99.0, for which the package is not built" in show(project, home)
    assert not file_of(home).exists()


def test_without_a_package_nothing_happens(project, home):
    assert show(project, home, package=home / "nowhere") == ""
    assert not file_of(home).exists()


def test_an_empty_home_is_none(project, home):
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    pretend(home, f"-c) echo {suffix};; -m) echo {home}/${{HOME-unset}};;")
    assert f"{home}/unset/binnacle.pth" in show(project, home, HOME="")
