# SPDX-License-Identifier: Apache-2.0
"""sdk/docs/python-models.md: its scripts, one after the other, print what it says."""

import contextlib
import io
import re


def test_scripts_print_what_the_guide_says(project, monkeypatch):
    monkeypatch.chdir(project)
    guide = (project / "sdk/docs/python-models.md").read_text()
    fences = re.findall(r"^```(python|text)\n(.*?)^```$", guide, re.MULTILINE | re.DOTALL)
    names = {"__name__": "guide"}
    printed = None
    for kind, text in fences:
        if kind == "text":
            assert printed == text
        else:
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile(text, "python-models.md", "exec"), names)
            printed = out.getvalue()
    assert [kind for kind, _ in fences] == ["python", "text"] * 2
