# SPDX-License-Identifier: Apache-2.0
"""The first page's form: README.md has few lines, short ones, and these headings in this order."""
import re

MOST_LINES = MOST_COLUMNS = 160
HEADINGS = ["# Binnacle", "## Run it", "## Your own data in three commands", "## The filter in twenty lines", "## A plugin",
            "## Python, C++, C, live", "## What it does, and what not", "## How good", "## How fast", "## How sure",
            "## How it compares", "## Where next"]
KNOWN = "known when settings were chosen"


def without_fences(text):
    return re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)


def section(text, heading):
    return text.partition(f"{heading}\n")[2].partition("\n## ")[0]


def fence(text, language):
    """Lines of the first fence of a language; none without it."""
    found = re.search(rf"^```{language}\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    return found[1].splitlines() if found else []


def faults_of(text):
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        yield f"{len(lines)} lines; it may have {MOST_LINES}"
    for number, line in enumerate(lines, 1):
        if len(line) > MOST_COLUMNS:
            yield f"line {number}: {len(line)} columns; it may have {MOST_COLUMNS}"
    headings = re.findall(r"^#+ .*$", without_fences(text), flags=re.MULTILINE)
    if headings != HEADINGS:
        yield f"the headings are {headings}, not {HEADINGS}"
    if not re.match(r"# Binnacle\n\n\*\*[^\n]+\*\*\n\n!\[[^\n]+\]\([^\n]+\)\n", text):
        yield "it does not begin with one line and the picture"
    if len(fence(section(text, HEADINGS[1]), "text")) != 1 + 10:
        yield "the first run does not show ten lines"
    if len(fence(section(text, HEADINGS[2]), "sh")) != 3:
        yield "there are not three commands for your own data"
    if not 15 <= len(fence(section(text, HEADINGS[3]), "json")) <= 20:
        yield "the filter does not have twenty lines"
    rows = [line for line in section(text, HEADINGS[7]).splitlines() if line.startswith("|")]
    if len(rows) != 2 + 4 or not all("](" in row for row in rows[2:]):
        yield "accuracy does not have four rows with a link each"
    if " ".join(text.split()).count(KNOWN) != 1:
        yield f"it does not say once: {KNOWN}"
