#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A Markdown page of the Python package's public names, from its sources: python_api.py PACKAGE PAGE

Exit status 1, with a line each, where a public class or function has no docstring.
"""
import ast
import inspect
import re
import sys
from pathlib import Path


def markdown(docstring):
    """A docstring as Markdown: what is indented is code, and * and _ are themselves."""
    lines, is_code = [], False
    for line in inspect.cleandoc(docstring).splitlines():
        if line.startswith("    ") != is_code and (line or not is_code):
            is_code = not is_code
            if not is_code and lines[-1] == "":
                lines.pop()
            lines.append("```python" if is_code else "```\n")
        if is_code:
            lines.append(line[4:])
        else:
            lines.append(re.sub(r"`[^`]*`|[*_<]", lambda m: m[0] if len(m[0]) > 1 else "\\" + m[0], line))
    return "\n".join(lines + ["```"] if is_code else lines)


class Package:
    def __init__(self, folder):
        self.problems, self.found, self.imported, self.public = [], {}, {}, []
        trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("_*.py*"))}
        self.text = ast.get_docstring(trees[folder / "__init__.py"])
        for path, tree in trees.items():
            for node in tree.body:
                if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                    self.found[path.stem, node.name] = (path, node)
        for node in trees[folder / "__init__.py"].body:
            if isinstance(node, ast.ImportFrom):
                self.imported.update({alias.asname or alias.name: (node.module, alias.name) for alias in node.names})
            if isinstance(node, ast.Assign) and node.targets[0].id == "__all__":
                self.public = ast.literal_eval(node.value)

    def said(self, path, node, name):
        """Its docstring, which classes and functions have, and methods may have. Stubs of what is C++ have none."""
        text = ast.get_docstring(node)
        if text is None and path.suffix == ".py" and "." not in name:
            self.problems.append(f"{path}:{node.lineno}: {name} has no docstring")
        return markdown(text or "")

    def member(self, path, node, owner):
        is_property = any(getattr(mark, "id", "") == "property" for mark in node.decorator_list)
        arguments = re.sub(r"^(self|cls)(, |$)", "", ast.unparse(node.args))
        result = f" -> {ast.unparse(node.returns)}" if node.returns else ""
        signature = node.name + ("" if is_property else f"({arguments})") + result
        text = self.said(path, node, f"{owner}.{node.name}")
        return f"- `#!python {signature}`\n\n" + "".join(f"    {line}\n" if line else "\n" for line in text.splitlines())

    def section(self, name):
        if self.imported.get(name) not in self.found:
            return None
        path, node = self.found[self.imported[name]]
        if isinstance(node, ast.FunctionDef):
            result = f" -> {ast.unparse(node.returns)}" if node.returns else ""
            head = f"{name}({ast.unparse(node.args)}){result}"
            return f"## {name} {{ #{name} }}\n\n`#!python {head}`\n\n{self.said(path, node, name)}\n"
        lines = [f"## {name} {{ #{name} }}\n\n`#!python class {name}`\n\n{self.said(path, node, name)}\n"]
        for member in node.body:
            if isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
                lines.append(self.member(path, member, name))
        return "\n".join(lines)


def main(folder, page):
    package = Package(Path(folder))
    sections = [section for section in map(package.section, package.public) if section]
    path = Path(page)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"# Python package\n\n{markdown(package.text)}\n\n" + "\n".join(sections), encoding="utf-8")
    for problem in package.problems:
        print(problem, file=sys.stderr)
    return 1 if package.problems or not sections else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
