# SPDX-License-Identifier: Apache-2.0
"""Runs the Python of a document and compares what it prints: python_page.py PROJECT PAGE…

The python blocks of a page are one session: they run in their order, and names go on from one to the next. A text block that
follows one is what it prints; one that prints needs such a block. All runs in a scratch folder with the project's configs.
"""

import contextlib
import io
import os
import pathlib
import sys
import tempfile
import traceback


def fences_of(text):
    """(language, first line of what is in it, text) of each fenced block."""
    fences, inside = [], None
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("```"):
            if inside:
                inside[2].append(line)
        elif inside:
            fences.append((inside[0], inside[1], "".join(line + "\n" for line in inside[2])))
            inside = None
        else:
            inside = (line[3:].strip(), number + 1, [])
    return fences


def snippets_of(text):
    """(first line, code, what it prints) of each python block."""
    fences = fences_of(text)
    for (language, line, code), following in zip(fences, fences[1:] + [("", 0, "")]):
        if language == "python":
            is_shown = following[0] == "text" and not following[2].startswith("$ ")
            yield line, code, following[2] if is_shown else ""


def without_blanks_at_ends(text):
    return [line.rstrip() for line in text.rstrip().splitlines()]


def faults_of(page, text):
    """Runs the snippets of a page; "page:line: …" of each that fails or prints something else."""
    names, faults, count = {"__name__": "__main__"}, [], 0
    for line, code, expected in snippets_of(text):
        count += 1
        printed = io.StringIO()
        try:
            # Blank lines before it, so that tracebacks show lines of the page.
            compiled = compile("\n" * (line - 1) + code, page, "exec")
            with contextlib.redirect_stdout(printed):
                exec(compiled, names)
        except Exception:
            faults.append(f"{page}:{line}: {traceback.format_exc()}")
            continue
        if without_blanks_at_ends(printed.getvalue()) != without_blanks_at_ends(expected):
            faults.append(f"{page}:{line}: prints\n{printed.getvalue()}and the page shows\n{expected}")
    return faults if count else [f"{page}: has no python block"]


def main(project, *pages):
    faults = []
    for page in pages:
        text = (pathlib.Path(project) / page).read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(pathlib.Path(project) / "configs", pathlib.Path(folder) / "configs")
            os.chdir(folder)
            faults += faults_of(page, text)
            os.chdir(project)
    print("\n".join(faults) or "ok")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
