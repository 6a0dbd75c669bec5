#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether a built site is whole: links.py SITE [HEADERS…]

A line for each link of a page to a file or an anchor that is not there, for each page that takes something from the
network or shows marks of Markdown, and for each of the HEADERS (binnacle/session.hpp) that has no page. Exit status 1 if
there is one.
"""
import posixpath
import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

OPAQUE = {"code", "pre", "script", "style"}
FETCHED = {("link", "href"), ("script", "src"), ("img", "src"), ("iframe", "src"), ("source", "src")}

# Tables, fences, links and lists as text; \x02 and \x03 stand for escapes that a table of contents forgot.
NOT_UNDERSTOOD = re.compile("[\x02\x03]|^\\s*\\|.*\\|\\s*$|```|\\]\\(|\\*\\*|^[-*] ", re.M)


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.fetched, self.broken = set(), [], [], []
        self.code = 0
        self.feed(text)

    def handle_endtag(self, tag):
        self.code -= tag in OPAQUE

    def handle_starttag(self, tag, attributes):
        self.code += tag in OPAQUE
        for name, value in attributes:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif name in ("href", "src") and value is not None:
                self.links.append((self.getpos()[0], value))
                is_canonical = tag == "link" and ("rel", "canonical") in attributes
                if (tag, name) in FETCHED and re.match(r"(https?:)?//", value) and not is_canonical:
                    self.fetched.append((self.getpos()[0], value))

    def handle_data(self, data):
        if not self.code and NOT_UNDERSTOOD.search(data):
            self.broken.append((self.getpos()[0], data.strip()[:60]))


def faults_of(name, pages, files):
    page = pages[name]
    for line, text in page.broken:
        yield f"{name}:{line}: Markdown that was not understood: {text!r}"
    for line, link in page.fetched:
        yield f"{name}:{line}: takes {link} from the network"
    for line, link in page.links:
        parts = urlsplit(link)
        if parts.scheme or parts.netloc or name == "404.html":
            continue
        target = posixpath.normpath(posixpath.join(posixpath.dirname(name), unquote(parts.path))) if parts.path else name
        target = target if target in files else posixpath.normpath(posixpath.join(target, "index.html"))
        if target not in files:
            yield f"{name}:{line}: {link} leads nowhere"
        elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors | {"__top"}:
            yield f"{name}:{line}: {link}: {target} has no such anchor"


def main(site, headers):
    site = Path(site)
    files = {path.relative_to(site).as_posix() for path in site.rglob("*") if path.is_file()}
    pages = {name: Page((site / name).read_text(encoding="utf-8")) for name in sorted(files) if name.endswith(".html")}
    faults = [] if pages else [f"{site} has no page"]
    for name in pages:
        faults += faults_of(name, pages, files)
    faults += [f"{header}: no page" for header in headers if f"api/{header}.html" not in pages]
    print("\n".join(faults) if faults else f"{len(pages)} pages, {sum(len(page.links) for page in pages.values())} links")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
