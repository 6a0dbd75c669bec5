#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tree that MkDocs builds the site from: assemble.py ROOT TREE [REFERENCE]

Pages keep their places below TREE, so that links between them stay as they are; a source file that a page links to becomes
a page that shows it. TREE/api has the headers' pages already, by api.py. TREE/../mkdocs.yml is ROOT/sdk/site/mkdocs.yml
with the navigation's patterns filled in and without the pages that there are not. REFERENCE, which the build made, becomes
sdk/docs/reference.md. Exit status 1, with a line each, where a
link leads nowhere or a page is in no navigation.
"""
import posixpath
import re
import shutil
import sys
from pathlib import Path

PAGES = ["*.md", "kernel/*.md", "sdk/docs/**/*.md", "configs/**/*.md", "plugins/*/README.md", "sdk/examples/**/*.md"]
SHOWN = {".json": "json", ".hpp": "cpp", ".cpp": "cpp", ".h": "c", ".py": "python", ".sh": "sh", "": "sh", ".txt": "text",
         ".csv": "text"}
PICTURES = {".svg", ".webp", ".png", ".jpg"}
MOST_SHOWN = 200_000  # bytes
HEADERS = re.compile(r"^(kernel/include|sdk/testing/include|sdk/c/include)(?:/binnacle)?(/.+)?$")
LINK = re.compile(r"(!?)\[((?:[^][]|\[[^]]*\])*)\]\(([^()\s]+)\)")
CODE = re.compile(r"(`+)(?:(?!\1).)+\1")


def pages_of(root):
    found = {path.relative_to(root) for pattern in PAGES for path in root.glob(pattern) if path.is_file()}
    return sorted(path.as_posix() for path in found if "build" not in path.parts)


class Tree:
    def __init__(self, root, tree, made):
        self.root, self.tree, self.problems, self.shown = root, tree, [], set()
        self.made = made  # {page: its file}, of those that the repository does not have
        self.pages = sorted({*pages_of(root), *made})

    def write(self, name, text):
        path = self.tree / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def page(self, name):
        lines, is_code, is_list, is_apart = [], False, False, False
        for number, line in enumerate(self.made.get(name, self.root / name).read_text(encoding="utf-8").splitlines(), 1):
            before = lines[-1] if lines else ""
            is_fence, is_item = bool(re.match(r"\s*```", line)), bool(re.match(r"([-*]|\d+\.) ", line))
            if not is_code:
                # Python-Markdown wants an empty line before a list or a table, and four blanks where two go on with an item.
                if before and (is_item and (is_apart or not is_list) or line.startswith("|") and not before.startswith("|")):
                    lines.append("")
                is_list = is_item or is_list and line[:1] in ("", " ")
                is_apart = not is_item and (is_apart or not line)  # behind the item's first paragraph
            if is_list and (is_code or is_fence or is_apart and re.match(r" {2,3}\S", line)):
                line = "  " + line
            if is_fence:
                is_code = not is_code
            elif not is_code:
                line = LINK.sub(lambda match, at=number: self.link(name, at, match), line)
                line = CODE.sub(lambda match: match[0].replace("\\|", "|"), line) if line.startswith("|") else line
            lines.append(line)
        head = "---\nhide: [navigation]\n---\n" if name == "README.md" else ""
        self.write(name, head + "\n".join(lines) + "\n")

    def link(self, name, number, match):
        picture, text, target = match.groups()
        address, mark, anchor = target.partition("#")
        if re.match(r"[a-z]+:", target) or not address:
            return match[0]
        there = posixpath.normpath(posixpath.join(posixpath.dirname(name), address))
        if there not in self.pages:
            try:
                there = self.other(there)
            except FileNotFoundError:
                self.problems.append(f"{name}:{number}: the link to {target} leads nowhere")
                return text
        if there is None:
            return text
        return f"{picture}[{text}]({posixpath.relpath(there, posixpath.dirname(name) or '.')}{mark}{anchor})"

    def other(self, name):
        """The page that stands for what is no page; None: a folder or a file that is not shown."""
        path, header = self.root / name, HEADERS.match(name)
        if not path.exists() or name.startswith(".."):
            raise FileNotFoundError
        if header:
            page = f"api{'/binnacle' if header[2] and not header[1].endswith('/c/include') else ''}{header[2] or ''}"
            return page + ".md" if header[2] else "api/README.md"
        if path.is_dir():
            return name + "/README.md" if name + "/README.md" in self.pages else None
        if path.suffix in PICTURES:
            (self.tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, self.tree / name)
            return name
        if path.suffix not in SHOWN or path.stat().st_size > MOST_SHOWN:
            return None
        if name not in self.shown:
            self.shown.add(name)
            text = path.read_text(encoding="utf-8").rstrip()
            head = f"---\nhide: [navigation, toc]\n---\n# {path.name}\n\n`{name}`\n\n"
            self.write(name + ".md", f"{head}~~~~{SHOWN[path.suffix]}\n{text}\n~~~~\n")
        return name + ".md"

    def title(self, name):
        if name.startswith("api/") and not name.endswith("README.md"):
            return Path(name).stem
        for line in (self.tree / name).read_text(encoding="utf-8").splitlines():
            if line.startswith("# "):
                return line[2:].replace("`", "").replace("\\", "")
        return Path(name).stem

    def navigation(self):
        """mkdocs.yml, with patterns in the place of pages filled in."""
        template = (self.root / "sdk/site/mkdocs.yml").read_text(encoding="utf-8").splitlines()
        entries = [re.match(r"( +- )(?:(.+): )?(\S+\.md)$", line) for line in template]
        lines, listed = [], {entry[3] for entry in entries if entry}
        for line, entry in zip(template, entries):
            if not entry:
                lines.append(line)
                continue
            lead, title, pattern = entry.groups()
            for path in sorted(self.tree.glob(pattern)):
                name = path.relative_to(self.tree).as_posix()
                if name not in listed or name == pattern:
                    listed.add(name)
                    lines.append(f'{lead}"{title or self.title(name)}": {name}')
        without = [page for page in self.pages if page not in listed]
        self.problems += [f"{page}:1: sdk/site/mkdocs.yml has no place for this page" for page in without]
        # A title over pages of which there is none.
        kept = []
        for line, after in zip(lines, lines[1:] + [""]):
            is_empty = re.match(r" +- [^\"]+:$", line) and len(after) - len(after.lstrip()) <= len(line) - len(line.lstrip())
            kept += [] if is_empty else [line]
        (self.tree.parent / "mkdocs.yml").write_text("\n".join(kept) + "\n", encoding="utf-8")


def main(root, tree, reference=None):
    tree = Tree(Path(root).resolve(), Path(tree), {"sdk/docs/reference.md": Path(reference)} if reference else {})
    for page in tree.pages:
        tree.page(page)
    shutil.copyfile(tree.root / "sdk/site/site.css", tree.tree / "site.css")
    tree.navigation()
    for problem in tree.problems:
        print(problem, file=sys.stderr)
    return 1 if tree.problems else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
