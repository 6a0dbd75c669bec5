#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The vocabulary of what the command prints: printed_words.py COMMAND

Reads `describe --all`, which has the description of every parameter, port and field, and the --help of every verb. Reports
the words that vocabulary.py excludes from sources and from pages, as `binnacle …:line: word: say …`; exit status 1 if there
is one, 2 if the command printed nothing that can be checked.
"""
import re
import subprocess
import sys

sys.dont_write_bytecode = True
from vocabulary import avoided, compiled  # noqa: E402


def printed(command, *words):
    return subprocess.run([command, *words], capture_output=True, text=True, check=True).stdout


def texts(command):
    """(how it is printed, text) of all that is checked."""
    main = printed(command, "--help")
    yield "binnacle --help", main
    verbs = re.findall(r"^  ([a-z]+) +[A-Z]", main, re.MULTILINE)
    for verb in verbs:
        yield f"binnacle {verb} --help", printed(command, verb, "--help")
    if len(verbs) < 10:
        raise ValueError(f"--help lists {len(verbs)} verbs")
    yield "binnacle describe --all", printed(command, "describe", "--all")


def offences(text):
    """(line number, word, what to say instead)"""
    for phrase, pattern, instead in avoided():
        for match in pattern.finditer(text):
            yield text.count("\n", 0, match.start()) + 1, phrase, instead
    for word, pattern, instead, exceptions in compiled():
        for number, line in enumerate(text.splitlines(), 1):
            for exception in exceptions:
                line = exception.sub("", line)
            if pattern.search(line):
                yield number, word, instead


def main(command):
    try:
        all_texts = list(texts(command))
    except (OSError, ValueError, subprocess.CalledProcessError) as error:
        print(f"nothing to check: {error}")
        return 2
    found = [(name, *offence) for name, text in all_texts for offence in offences(text)]
    for name, number, word, instead in found:
        print(f"{name}:{number}: {word}: say {instead}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
