# SPDX-License-Identifier: Apache-2.0
"""Types of the package: a checker accepts the package, and sees in a user's program what is what."""

import importlib.util
import re
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="no mypy (Debian package mypy)")

PROGRAM = """
import binnacle as bn

config = bn.load("ins.json", set={"/filters/ins/measurements/fix/gate": 0.99}, vars={"drives": "data"})
result = config.run(seed=1)
reveal_type(config)
reveal_type(config.check())
reveal_type(result["ins"]["position"].t)
reveal_type(result["ins"].errors["position.north"].sigma)
reveal_type(result.verdict)
bn.load(3)
bn.load("ins.json").run(seed="one")
result.no_such
"""

REVEALED = {
    6: "binnacle._composition.Composition",
    7: "builtins.list[binnacle._errors.Diagnostic]",
    8: "numpy.ndarray[Any, Any]",
    9: "Union[numpy.ndarray[Any, Any], None]",
    10: "builtins.str",
}
WRONG = {11: "arg-type", 12: "arg-type", 13: "attr-defined"}


def check(project, folder, *arguments):
    """Lines that mypy printed, without its summary."""
    command = [sys.executable, "-m", "mypy", "--config-file=", "--no-error-summary", f"--cache-dir={folder / 'cache'}", *arguments]
    done = subprocess.run(command, cwd=project / "sdk/python", capture_output=True, text=True)
    assert done.stderr == ""
    return done.stdout.splitlines()


def test_package_is_typed_right(project, tmp_path):
    assert check(project, tmp_path, "-p", "binnacle") == []


def test_a_program_sees_types(project, tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    printed = check(project, tmp_path, tmp_path / "program.py")
    by_line = {int(re.search(r":(\d+): ", line)[1]): line for line in printed}
    for line, type_name in REVEALED.items():
        assert f'is "{type_name}"' in by_line[line], printed
    for line, code in WRONG.items():
        assert f"[{code}]" in by_line[line], printed
