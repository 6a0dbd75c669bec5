#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each archive of the corpus is what `tests/fuzz/run --pack` makes of its inputs, to the byte, whatever their times are."""
import importlib.machinery
import importlib.util
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("run", str(Path(__file__).with_name("run")))
run = importlib.util.module_from_spec(importlib.util.spec_from_loader("run", loader))
loader.exec_module(run)

targets = sorted(source.stem for source in (run.HERE / "targets").glob("*.cpp"))
differ = []
with tempfile.TemporaryDirectory() as scratch:
    for target in targets:
        folder, again = Path(scratch) / target, Path(scratch) / f"{target}.tar"
        count = run.pack(run.unpack(target, folder), again)
        print(f"{target:10} {count:5} inputs")
        if count == 0 or again.read_bytes() != run.archive_of(target).read_bytes():
            differ.append(target)
if differ or not targets:
    sys.exit(f"not as tests/fuzz/run packs it: {', '.join(differ)}")
