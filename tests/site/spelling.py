#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Spelling of the pages' prose by aspell, British with -ize: spelling.py ROOT WORDS

A line `path:line: word` for each word that neither aspell nor the list WORDS knows, and one where the list is not sorted.
A word of the list may be capitalized and have an 's; one with a capital stands for itself alone. Exit status 1 if there is
one, 77 (1 in CI) without aspell and its dictionary.
"""
import os
import re
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "sdk/site"))
from assemble import pages_of  # noqa: E402
from prose import prose  # noqa: E402

ASPELL = ["aspell", "list", "--encoding=utf-8", "--master=en_GB-ize", "--ignore=2", "--dont-use-other-dicts"]


def aspell(text):
    return subprocess.run(ASPELL, input=text, capture_output=True, text=True, check=True).stdout.split()


def is_listed(word, words):
    own = word[:-2] if word.endswith("'s") else word
    return bool({word, own, own.lower(), own[:1].lower() + own[1:]} & words)


def misspelt(root, words):
    texts = {page: prose((root / page).read_text(encoding="utf-8").replace("’", "'")) for page in pages_of(root)}
    unknown = set(aspell("\n".join("\n".join(lines) for lines in texts.values())))
    unknown = {word for word in unknown if not is_listed(word, words)}
    for page, lines in texts.items():
        for number, line in enumerate(lines, 1):
            for word in re.findall(r"[^\W\d_]+(?:'[^\W\d_]+)*", line):
                if word in unknown:
                    yield f"{page}:{number}: {word}"


def main(root, list_path):
    try:
        aspell("")
    except (OSError, subprocess.CalledProcessError):
        print("SKIPPED: no aspell with a British dictionary (Debian packages aspell, aspell-en)")
        return 1 if os.environ.get("CI") == "true" else 77
    words = Path(list_path).read_text(encoding="utf-8").split()
    faults = list(misspelt(Path(root), set(words)))
    ordered = sorted(set(words), key=lambda word: (word.lower(), word))
    if words != ordered:
        first = next((a for a, b in zip(words, ordered) if a != b), words[-1])
        faults.append(f"{list_path}: not sorted, or a word twice, at {first}")
    print("\n".join(faults) if faults else f"{len(words)} words listed; nothing misspelt")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
