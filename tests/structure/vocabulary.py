#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The vocabulary of the project: vocabulary.py [--prune] ROOT

Reports every word that TABLE excludes, as `path:line: word: say …`; exit status 1 if there is one. Files that
vocabulary_todo.txt lists for a word are still to be rewritten, and are counted only. --prune takes out of that list what is done.
"""
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
SUFFIXES = {".cpp", ".hpp", ".inc", ".py", ".js", ".html", ".md", ".json", ".txt", ".cmake", ".in", ".sh", ".awk", ""}
# Places whose words are others', or old ones on purpose.
LEFT_OUT = re.compile(
    r"^(build|\.git|\.cache)(/|$)|(^|/)LICENSE$|license\.txt$|^CHANGELOG\.md$|^tests/structure/(vocabulary|bad/vocabulary)"
)


# Word, what is not said, what is said instead, and what is no offence: the last is taken out of a line before it is searched.
# Case is ignored, but for "arm", since ARM is a processor.
TABLE = [
    ("tell", r"\b(tells?|told|telling)\b", "reports, specifies, provides, gives, means, shows", [r"\btell(s|ing)?( [\w']+){0,5} apart\b", r"\btold apart\b"]),
    ("has to say", r"\bha(s|ve|d) to say\b", "reports, specifies", []),
    ("mend", r"\bmend(s|ed|ing)?\b", "fix, remedy", []),
    ("moved on", r"\b(moved|moves) on\b", "propagated, advanced", []),
    ("worked off", r"\bwork(s|ed|ing)? off\b", "propagated, advanced", []),
    ("hear", r"\b(hears?|heard|hearing)\b", "subscribes to, receives", []),
    ("listen", r"\blisten(s|ed|ing|ers?)?\b", "subscribes to, subscriber", [r"\bview\.listeners\b", r"\b(const )?listener( of view|\(| of)", r"listeners: \[\]"]),
    ("ear", r"\bears?\b", "subscriber, collector", []),
    ("speak", r"\b(speaks?|spoke|spoken|speaking)\b", "emits, reports", []),
    ("tape", r"\btapes?\b", "step log, record", []),
    ("remark", r"\bremarks?\b", "warning, note", []),
    ("circle", r"\bcircles?\b", "cycle", [r"</?circle", r"'circle'", r"\.distribution circle", r"\b(great|full|unit) circles?\b"]),
    ("arm", r"\barms?\b", "lever arm, lever_arm", [r"\blever[ -]arms?\b", r"formerly\(\"arm\"\)"]),
    ("sure", r"\btoo (sure|modest)\b", "overconfident, conservative", []),
    ("cautious", r"\bcautious(ly)?\b", "conservative", []),
    ("desk", r"\bdesks?\b", "coordinator", []),
    ("crew", r"\bcrews?\b", "workers", []),
    ("muster", r"\bmuster(s|ed|ing)?\b", "work queue", []),
    ("books", r"\bbooks\b", "run log", []),
    ("patience", r"\bpatien(ce|t|tly)\b", "timeout", []),
    ("specimen", r"\bspecimens?\b", "fixture", []),
    ("animal", r"\banimals?\b", "faulty plugin", []),
    ("zoo", r"\bzoos?\b", "faulty plugins", []),
    ("border", r"\bborders?\b", "ABI rules, library boundary", []),
    ("sum of blocks", r"\bsum of its blocks\b", "dimension, degrees of freedom", []),
]


def compiled():
    for word, pattern, instead, exceptions in TABLE:
        flags = 0 if word == "arm" else re.IGNORECASE
        yield word, re.compile(pattern, flags), instead, [re.compile(e, flags) for e in exceptions]


def files(root):
    for path in sorted(root.rglob("*")):
        name = path.relative_to(root).as_posix()
        if path.suffix in SUFFIXES and path.is_file() and not path.is_symlink() and not LEFT_OUT.search(name):
            yield name, path


def offences(root):
    """(word, path, line number, what to say instead)"""
    table = list(compiled())
    for name, path in files(root):
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except UnicodeDecodeError:
            continue
        text = "\n".join(lines)
        for word, pattern, instead, exceptions in table:
            if not pattern.search(text):
                continue
            for number, line in enumerate(lines, 1):
                for exception in exceptions:
                    line = exception.sub("", line)
                for _ in pattern.finditer(line):
                    yield word, name, number, instead


def main():
    arguments = sys.argv[1:]
    prune = "--prune" in arguments
    root = Path([a for a in arguments if a != "--prune"][0])
    list_path = HERE / "vocabulary_todo.txt"
    lines = list_path.read_text(encoding="utf-8").splitlines() if list_path.exists() else []
    head = [line for line in lines if line.startswith("#")]
    todo = {tuple(line.split(": ", 1)) for line in lines if line and not line.startswith("#")}

    found = list(offences(root))
    left = {(word, name) for word, name, _, _ in found}
    if prune:
        kept = sorted(f"{word}: {name}" for word, name in todo & left)
        list_path.write_text("\n".join(head + kept) + "\n", encoding="utf-8")
        return 0
    new = [(word, name, number, instead) for word, name, number, instead in found if (word, name) not in todo]
    for word, name, number, instead in new:
        print(f"{name}:{number}: {word}: say {instead}")
    pending = [word for word, name, _, _ in found if (word, name) in todo]
    print(f"{len(new)} new, {len(pending)} in {len(todo & left)} places of vocabulary_todo.txt")
    done = sorted(todo - left)
    if done and root.joinpath("tests/structure/vocabulary_todo.txt").exists():
        print(f"{len(done)} lines of vocabulary_todo.txt are done: tests/structure/vocabulary.py --prune .")
    return 1 if new else 0


sys.exit(main())
