# SPDX-License-Identifier: Apache-2.0
"""The prose of a Markdown page, line for line: without code, addresses, HTML and titles of papers."""
import re

INLINE = [
    re.compile(r"(`+)(?:(?!\1).)+\1"),            # code
    re.compile(r"<!--.*?-->|</?[a-zA-Z][^>]*>"),  # HTML
    re.compile(r"(?<=\])\([^()\s]*(?:\([^()\s]*\))*[^()\s]*\)"),  # targets of links
    re.compile(r"https?://\S+"),
    re.compile(r"^Source: .*|(?<!\*)\*[^*]{20,}\*(?!\*)"),
    re.compile(r"[\w./*-]*\w\.[a-z]{1,8}\b(?<!e\.g)(?<!i\.e)|\w+_\w+"),  # files and what else has a name of its own
]


def prose(text):
    """The text's lines with everything else blanked; as many as it has."""
    lines, is_code = [], False
    for line in text.splitlines():
        if re.match(r"\s*(```|~~~)", line):
            is_code = not is_code
            line = ""
        elif is_code:
            line = ""
        for pattern in INLINE:
            line = pattern.sub(" ", line)
        lines.append(line)
    return lines
