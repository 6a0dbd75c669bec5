#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every relative link of the Markdown below a folder leads to a file, and its #part to a heading: links.py FOLDER"""
import re
import sys
from pathlib import Path

LINK = re.compile(r"\]\(([^)\s]+)\)")


def without_code(text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`\n]*`", "", text)


def anchors(path):
    """The #parts of a page, as GitHub makes them of its headings."""
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    found = set()
    for heading in re.findall(r"^#+ +(.*)$", text, flags=re.MULTILINE):
        shown = re.sub(r"\]\([^)]*\)", "]", heading).lower()
        slug = re.sub(r"[^\w\- ]", "", shown).replace(" ", "-")
        number = 0
        while (slug if number == 0 else f"{slug}-{number}") in found:
            number += 1
        found.add(slug if number == 0 else f"{slug}-{number}")
    return found


def fault(page, link):
    if "://" in link or link.startswith("mailto:"):
        return None
    place, _, part = link.partition("#")
    target = page.parent / place if place else page
    if not target.exists():
        return "is not there"
    if part and target.suffix == ".md" and part not in anchors(target):
        return "has no such part"
    return None


def main():
    root = Path(sys.argv[1])
    pages = sorted(root.rglob("*.md"))
    links = faults = 0
    for page in pages:
        for link in LINK.findall(without_code(page.read_text(encoding="utf-8"))):
            links += 1
            what = fault(page, link)
            if what:
                faults += 1
                print(f"{page.relative_to(root)}: {link} {what}")
    print(f"{links} links in {len(pages)} pages, {faults} dead")
    return 0 if faults == 0 and links > 100 else 1


sys.exit(main())
