# SPDX-License-Identifier: Apache-2.0
"""Types of the package: a checker accepts the package, and sees in a user's program what is what."""

import ast
import importlib.util
import pathlib
import re
import subprocess
import sys

import binnacle as bn
import pytest

needs_mypy = pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="no mypy (Debian package mypy)")

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


@needs_mypy
def test_package_is_typed_right(project, tmp_path):
    assert check(project, tmp_path, "-p", "binnacle") == []


@needs_mypy
def test_a_program_sees_types(project, tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    printed = check(project, tmp_path, tmp_path / "program.py")
    by_line = {int(re.search(r":(\d+): ", line)[1]): line for line in printed}
    for line, type_name in REVEALED.items():
        assert f'is "{type_name}"' in by_line[line], printed
    for line, code in WRONG.items():
        assert f"[{code}]" in by_line[line], printed


def arguments_of(function):
    """Their names, as pybind11 has them in the first line of the docstring."""
    inside = re.search(r"\((.*)\) ->", function.__doc__.splitlines()[0])[1]
    return re.findall(r"(?:^|, )(\w+): ", inside)


def described(tree, module):
    """(name, what it is in the module, arguments that the description has) of each function and method."""
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            yield from described(node, getattr(module, node.name))
        elif isinstance(node, ast.FunctionDef) and node.name != "__getattr__":
            yield node.name, getattr(module, node.name), [argument.arg for argument in node.args.args]


def test_module_in_cpp_is_as_it_is_described():
    tree = ast.parse(pathlib.Path(bn.__file__).with_name("_core.pyi").read_text())
    found = list(described(tree, bn._core))
    assert len(found) > 40
    for name, thing, arguments in found:
        assert isinstance(thing, property) or arguments_of(thing) == arguments, name
