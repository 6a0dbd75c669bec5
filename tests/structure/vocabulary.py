#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The vocabulary of the project: vocabulary.py ROOT

Reports every word that TABLE excludes, and in the prose of pages (*.md) every phrase of sdk/site/avoid.txt, as
`path:line: word: say …`; exit status 1 if there is one.
"""
import re
import sys
from pathlib import Path

SITE = Path(__file__).resolve().parents[2] / "sdk/site"
sys.path.insert(0, str(SITE))
sys.dont_write_bytecode = True
from prose import prose  # noqa: E402

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
    ("worked off", r"\bwork(s|ed|ing)?( (it|them|these|all))? off\b", "propagated, advanced", []),
    ("hear", r"\b(hears?|heard|hearing)\b", "subscribes to, receives", []),
    ("listen", r"\blisten(s|ed|ing|ers?)?\b", "subscribes to, subscriber", [r"\bview\.listeners\b", r"\b(const )?listener( of view|\(| of)", r"listeners: \[\]", r"::listen\(", r"\bacceptor_\.listen\("]),
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


def offences(sources):
    """(word, path, line number, what to say instead)"""
    table = list(compiled())
    for name, path in sources:
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


def avoided():
    """(phrase, pattern, what to say instead) of avoid.txt: "phrase: instead", where a * stands for any ending."""
    for line in (SITE / "avoid.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            phrase, instead = line.split(": ", 1)
            words = (re.escape(word).replace(r"\*", r"\w*") for word in phrase.split())
            yield phrase, re.compile(r"\b" + r"\s+".join(words) + r"\b", re.IGNORECASE), instead


def avoided_in_pages(sources):
    """The same as offences(); a phrase may go on in the next line."""
    phrases = list(avoided())
    for name, path in sources:
        if path.suffix == ".md":
            text = "\n".join(prose(path.read_text(encoding="utf-8")))
            for phrase, pattern, instead in phrases:
                for match in pattern.finditer(text):
                    yield phrase, name, text.count("\n", 0, match.start()) + 1, instead


def main():
    sources = list(files(Path(sys.argv[1])))
    found = [*offences(sources), *avoided_in_pages(sources)]
    for word, name, number, instead in found:
        print(f"{name}:{number}: {word}: say {instead}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
