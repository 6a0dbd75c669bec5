#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Manual pages and shell completion of a built command: generate.py COMMAND VERSION FOLDER

Leaves FOLDER/man/*.1.gz, FOLDER/bash/binnacle and FOLDER/zsh/_binnacle, and no page of an earlier build.
"""
import gzip
import shutil
import sys
from pathlib import Path

import bash_completion
import help_text
import man_pages
import zsh_completion


def main(command, version, folder):
    main_help, verbs = help_text.read(command)
    folder = Path(folder)
    for name in ("man", "bash", "zsh"):
        shutil.rmtree(folder / name, ignore_errors=True)
        (folder / name).mkdir(parents=True)
    for name, text in man_pages.pages(main_help, verbs, version):
        (folder / "man" / f"{name}.gz").write_bytes(gzip.compress(text.encode(), mtime=0))
    (folder / "bash" / "binnacle").write_text(bash_completion.script(verbs))
    (folder / "zsh" / "_binnacle").write_text(zsh_completion.script(verbs))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
