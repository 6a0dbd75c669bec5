#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How long functions and files are, in the project's own C++, Python and JavaScript.

sizes.py ROOT                what is longer than a function or a file may be; exit status 1 if there is one
sizes.py ROOT --kernel MOST  the kernel's lines of .hpp and .cpp against the most that it may have
sizes.py ROOT --cpp MOST     code lines (neither blank nor comment) of all C++ outside tests against the most that there may be

A function is counted from the first line of its head to its last brace, a lambda with the function that it stands in.
"""
import ast
import pathlib
import re
import sys

MOST_LINES_OF_FUNCTION = 60
MOST_LINES_OF_FILE = 600
OWN = ("kernel", "plugins", "sdk", "tests", "configs")
NOT_OWN = {"build", ".git", ".cache"}
CPP, PYTHON, JAVASCRIPT = {".cpp", ".hpp", ".h", ".inc"}, {".py"}, {".js"}
# Public helpers beside the kernel's own headers.
HELPERS = {"jacobian.hpp", "geodesy.hpp", "local_axes.hpp", "random.hpp"}


def blanked(text):
    """The text with everything but its newlines blanked."""
    return re.sub(r"[^\n]", " ", text)


CPP_TOKENS = re.compile(
    r'//(?:[^\n\\]|\\.)*|/\*.*?\*/|R"(?P<mark>[^()\\\s]{0,16})\(.*?\)(?P=mark)"'
    r"|\"(?:[^\"\\\n]|\\.)*\"|(?<![0-9A-Fa-f])'(?:[^'\\\n]|\\.)+'"
    r"|^[ \t]*#(?:[^\n\\]|\\.|\\\n)*",
    re.S | re.M)
JAVASCRIPT_TOKENS = re.compile(
    r"//[^\n]*|/\*.*?\*/|\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\\n]|\\.)*'|`(?:[^`\\]|\\.)*`"
    r"|(?<=[(,=:\[!&|?{};\n])[ \t]*/(?![/*])(?:[^/\\\n\[]|\\.|\[(?:[^\]\\\n]|\\.)*\])+/[gimsuy]*",
    re.S)

NO_FUNCTION = re.compile(r"\s*(?:template\s*<.*>\s*)?(?:inline\s+)?(?:typedef\s+)?"
                         r"(?:namespace|class|struct|union|enum|extern\s)\b(?![^{]*\)\s*(?:const|noexcept|override)?\s*$)", re.S)


def braces(code):
    """Positions of the closing brace by that of the opening one."""
    open_, pairs = [], {}
    for match in re.finditer(r"[{}]", code):
        if match.group() == "{":
            open_.append(match.start())
        elif open_:
            pairs[open_.pop()] = match.start()
    return pairs


def line_of(code, position):
    return code.count("\n", 0, position) + 1


def cpp_functions(code):
    """(first line, last line, head) of each function at file, namespace or class level."""
    pairs, position, head_start, depth = braces(code), 0, 0, 0
    while position < len(code):
        character = code[position]
        if character in "([":
            depth += 1
        elif character in ")]":
            depth -= 1
        elif depth == 0 and character in ";}":
            head_start = position + 1
        elif character == "{" and position in pairs:
            head, close = code[head_start:position], pairs[position]
            if depth > 0:  # an argument
                position = close
            elif NO_FUNCTION.match(head):
                head_start = position + 1
            elif ")" not in head or head.rstrip().endswith(("=", "return")):  # an initializer
                position = close
            elif re.search(r"\)\s*(?:noexcept\s*)?:", head) and re.match(r"\s*[,{]", code[close + 1:close + 200]) \
                    and re.search(r"[\w>]\s*$", head):
                position = close  # of a member, in a constructor's list
            else:
                start = head_start + len(head) - len(head.lstrip())
                yield line_of(code, start), line_of(code, close), " ".join(head.split())
                position, head_start = close, close + 1
        position += 1


def javascript_functions(code):
    """The same of functions, arrow functions with a block, and methods, nested ones too."""
    pairs = braces(code)
    heads = re.compile(r"(?:function\b[^(){}]*\((?:[^()]|\([^()]*\))*\)|(?:\((?:[^()]|\([^()]*\))*\)|\w+)\s*=>"
                       r"|^\s*(?!(?:if|for|while|switch|catch|function)\b)(?:async\s+|static\s+|get\s+|set\s+)?[\w$]+\s*"
                       r"\((?:[^()]|\([^()]*\))*\))\s*\{", re.M)
    for match in heads.finditer(code):
        close = pairs.get(match.end() - 1)
        if close is not None:
            start = match.start() + len(match.group()) - len(match.group().lstrip())
            yield line_of(code, start), line_of(code, close), " ".join(match.group()[:-1].split())


def python_functions(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.end_lineno, "def " + node.name


def name_in(head):
    """What a head is known by in the list: "Composer::add_part", "TEST_CASE 3"."""
    found = re.search(r"([\w:~$]+|operator\s*\S+)\s*\(", head) or re.search(r"([\w$]+)\s*=>?", head)
    return re.sub(r"^def ", "", found.group(1) if found else head)


def is_python(path):
    """By its name, or of a command without a suffix by its first line."""
    if path.suffix or not path.is_file():
        return path.suffix in PYTHON
    with path.open("rb") as file:
        return re.match(rb"#!.*python", file.readline()) is not None


def functions_of(path):
    text = path.read_text(encoding="utf-8")
    if is_python(path):
        return list(python_functions(text))
    tokens = CPP_TOKENS if path.suffix in CPP else JAVASCRIPT_TOKENS
    code = tokens.sub(lambda match: blanked(match.group()), text)
    return list(cpp_functions(code) if path.suffix in CPP else javascript_functions(code))


def own_files(root):
    for folder in OWN:
        for path in sorted((root / folder).rglob("*")):
            parts = path.relative_to(root).parts
            is_own = path.suffix in CPP | JAVASCRIPT or is_python(path)
            if is_own and path.is_file() and not NOT_OWN & set(parts):
                yield path


def too_long(root):
    """Lines "path: name", each with what is measured."""
    found = {}
    for path in own_files(root):
        place = path.relative_to(root).as_posix()
        count = len(path.read_text(encoding="utf-8").splitlines())
        if count > MOST_LINES_OF_FILE:
            found[place + ": the file"] = count
        seen = {}
        for first, last, head in functions_of(path):
            name = name_in(head)
            seen[name] = seen.get(name, 0) + 1
            if last - first + 1 > MOST_LINES_OF_FUNCTION:
                number = "" if seen[name] == 1 else f" {seen[name]}"
                found[f"{place}: {name}{number}"] = last - first + 1
    return found


def kernel_lines(root):
    files = [path for path in (root / "kernel").rglob("*") if path.suffix in {".hpp", ".cpp"} and path.name not in HELPERS]
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)


def code_lines(root):
    """{folder: lines of C++ that are neither blank nor comment}, without tests."""
    lines = {}
    for path in own_files(root):
        folder = path.relative_to(root).parts[0]
        if path.suffix in CPP and folder != "tests":
            code = CPP_TOKENS.sub(lambda match: blanked(match.group()) if match.group().startswith(("//", "/*")) else match.group(),
                                  path.read_text(encoding="utf-8"))
            lines[folder] = lines.get(folder, 0) + sum(bool(line.strip()) for line in code.splitlines())
    return lines


def main(arguments):
    root = pathlib.Path(arguments[0])
    if arguments[1:2] == ["--kernel"]:
        count, most = kernel_lines(root), int(arguments[2])
        print(f"kernel: {count} lines of .hpp and .cpp; it may have {most}")
        return 0 if 0 < count <= most else 1
    if arguments[1:2] == ["--cpp"]:
        lines, most = code_lines(root), int(arguments[2])
        folders = ", ".join(f"{folder} {count}" for folder, count in sorted(lines.items()))
        print(f"C++ outside tests: {sum(lines.values())} code lines ({folders}); there may be {most}")
        return 0 if 0 < sum(lines.values()) <= most else 1
    found = too_long(root)
    for entry, count in found.items():
        print(f"{entry}: {count} lines")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
