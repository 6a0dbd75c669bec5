#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""README.md and its claims: claims.py ROOT

Prints a line for each number, superlative, comparative or quantifier of the README that no row of sdk/docs/evidence/claims.md
covers, for each row that is in no sentence of the README, and for each figure that its command does not print or that its
file does not have. Quick commands are run, with $BINNACLE as `binnacle`. Exit status 1 if there is a line.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

CLAIMS = "sdk/docs/evidence/claims.md"
HEAD = ["claim", "figure", "oracle", "held by", "date"]
ORACLES = ("outside program", "independent implementation", "closed form", "own only")
SECONDS = 60

NUMBER_WORDS = {word: str(number) for number, word in enumerate(
    "two three four five six seven eight nine ten eleven twelve".split(), 2)} | {"twenty": "20", "hundred": "100", "half": "0.5", "twice": "2"}
QUANTIFIERS = """all any each every everything never always no none nobody nothing only alone without whole complete
    best better worst worse most least more less fewer faster fastest slower slowest larger largest smaller smallest
    same equal exact exactly identical last guarantee guarantees guaranteed""".split()
NUMBER = re.compile(r"(?<![\w.,-])\d+(?: \d{3})*(?:\.\d+)?(?!\w)")
FLAGGED = re.compile(NUMBER.pattern + r"|\b(?:" + "|".join([*NUMBER_WORDS, *QUANTIFIERS]) + r")\b", re.IGNORECASE)
LINK = re.compile(r"\[([^\]]*)\]\(([^()\s]*)\)")


def plain(text):
    """Markdown as it is read: without pictures and addresses, code as a mark."""
    text = re.sub(r"!\[[^\]]*\]\([^()\s]*\)", "", text)
    text = LINK.sub(r"\1", re.sub(r"`[^`]*`", "□", text))
    return " ".join(text.replace("*", "").split())


def blocks(text):
    """(first line, text) of each paragraph, list entry, row of a table and heading, without fences."""
    found, is_code, goes_on = [], False, False
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            is_code, goes_on = not is_code, False
        elif is_code or not line.strip() or re.fullmatch(r"[|: -]+", line):
            goes_on = False
        elif goes_on and not re.match(r"[|#]|[-*] ", line):
            found[-1][1] += " " + line.strip()
        else:
            found.append([number, line.strip()])
            goes_on = not re.match(r"[|#]", line)
    return found


def sentences(text):
    """(line, sentence or table cell) of a page, headings left out."""
    for number, block in blocks(text):
        if block.startswith("#"):
            continue
        if block.startswith("|"):
            parts = block.strip("|").split(" | ")
        else:
            parts = re.split(r"(?<=[.!?]) +(?=[A-Z*\[`])", re.sub(r"^- ", "", block))
        for part in parts:
            if plain(part):
                yield number, plain(part)


def cells(line):
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def rows(text):
    """[{column: cell}] of the page of claims."""
    table = [cells(line) for line in text.splitlines() if line.startswith("|") and not re.fullmatch(r"[|: -]+", line)]
    if HEAD not in table:
        raise ValueError(f"{CLAIMS}: no table has the head | {' | '.join(HEAD)} |")
    return [dict(zip(HEAD, [*row, "", "", "", ""])) for row in table[table.index(HEAD) + 1:]]


def phrases(row):
    """The words of the README that a row covers."""
    return [plain(phrase) for phrase in row["claim"].split("; ")]


def numbers(text):
    text = re.sub(r"\b[a-z]+\b", lambda match: NUMBER_WORDS.get(match[0], match[0]), text.lower())
    return [match.replace(" ", "") for match in NUMBER.findall(text)]


def is_rounded(number, others):
    places = len(number.partition(".")[2])
    return any(f"{float(other):.{places}f}" == f"{float(number):.{places}f}" for other in others)


def has(text, snippet):
    """Whether one block or line of a text has the snippet, in which … stands for anything; a number is a whole one."""
    words = ".*".join(re.escape(part.strip()) for part in snippet.split("…"))
    pattern = re.compile(r"(?<![\w.])" + words + r"(?!\w|\.\d)")
    lines = [plain(block.replace("`", "")) for _, block in blocks(text)] + [" ".join(line.split()) for line in text.splitlines()]
    return any(pattern.search(line) for line in lines)


class Checker:
    def __init__(self, root):
        self.root, self.printed = Path(root), {}

    def output_of(self, command):
        if command not in self.printed:
            with tempfile.TemporaryDirectory() as folder:
                os.symlink(os.environ["BINNACLE"], Path(folder) / "binnacle")
                environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "NO_COLOR": "1"}
                done = subprocess.run(["bash", "-c", command], cwd=self.root, env=environment, stdin=subprocess.DEVNULL,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=SECONDS, check=False)
            self.printed[command] = done.stdout if done.returncode == 0 else None
        return self.printed[command]

    def text_held(self, held):
        """The text that must have the figures, or a fault."""
        commands, link = re.findall(r"`([^`]+)`", held), LINK.search(held)
        words = re.fullmatch(r"(?:\[[^\]]*\]\([^()]*\)|`[^`]*`): (.+)", held)
        if not link and not words:
            if len(commands) != 1 or held != f"`{commands[0]}`":
                return None, "is held by no command, file or test"
            text = self.output_of(commands[0].replace("\\|", "|"))
            return text, None if text is not None else f"{commands[0]} fails"
        name = link[2].partition("#")[0] if link else commands[0]
        file = (self.root / CLAIMS).parent / name if link else self.root / name
        if not file.is_file():
            return None, f"{name} is not there"
        text = file.read_text(encoding="utf-8")
        if words and plain(words[1]) not in " ".join(text.split()):
            return None, f"{name} has no '{words[1]}'"
        if not words and not (commands and self.is_command(commands[0])):
            return None, "names no command that is there"
        return text, None

    def is_command(self, command):
        word = command.split()[0]
        return word == "binnacle" or (self.root / word).is_file() or shutil.which(word) is not None

    def faults_of_row(self, row):
        words, figure = " ".join(phrases(row)), row["figure"].replace("\\|", "|")
        if any(len(phrase.split()) < 2 for phrase in phrases(row)):
            yield "has a phrase of one word"
        if not row["oracle"].startswith(ORACLES):
            yield f"has the oracle '{row['oracle']}', none of: {', '.join(ORACLES)}"
        if not re.fullmatch(r"\d{4}-\d\d-\d\d", row["date"]):
            yield f"has no date, but '{row['date']}'"
        text, fault = self.text_held(row["held by"])
        if fault:
            yield fault
            return
        shown = [] if figure == "–" else figure.split("; ")
        for snippet in shown:
            if not has(text, plain(snippet.replace("`", ""))):
                yield f"has the figure '{snippet}', which is not in what holds it"
        there = [number for snippet in shown for number in numbers(plain(snippet.replace("`", "")))]
        for number in numbers(words):
            if not is_rounded(number, there):
                yield f"has the number {number}, and its figure has not"

    @staticmethod
    def uncovered(readme, claims):
        """(line, what, sentence) of each number or word in the README that no row covers."""
        for line, sentence in readme:
            spans = [(at.start(), at.end()) for row in claims for phrase in phrases(row) for at in re.finditer(re.escape(phrase), sentence)]
            for match in FLAGGED.finditer(sentence):
                if not any(begin <= match.start() and match.end() <= end for begin, end in spans):
                    yield line, match[0], sentence

    def faults(self):
        readme = list(sentences((self.root / "README.md").read_text(encoding="utf-8")))
        claims = rows((self.root / CLAIMS).read_text(encoding="utf-8"))
        for row in claims:
            for phrase in phrases(row):
                if not any(phrase in sentence for _, sentence in readme):
                    yield f"{CLAIMS}: '{phrase}' is not in the README"
            for fault in self.faults_of_row(row):
                yield f"{CLAIMS}: '{row['claim']}' {fault}"
        for line, what, sentence in self.uncovered(readme, claims):
            yield f"README.md:{line}: no row of {CLAIMS} covers '{what}' in: {sentence}"


def main(root):
    found = list(Checker(root).faults())
    print("\n".join(found) or "every claim of the README is held")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
