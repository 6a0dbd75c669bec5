# SPDX-License-Identifier: Apache-2.0
"""What `binnacle --help` and `binnacle VERB --help` print, as data: the one source of man pages and of completion."""
import re
import subprocess
from dataclasses import dataclass, field

WIDTH = 30  # the column where descriptions begin


@dataclass
class Entry:
    """An option or a positional argument."""

    names: list  # ["-o", "--output"]; of a positional ["CONFIG"]
    value: str = ""  # "FILE.json"; "" of a flag
    choices: list = field(default_factory=list)
    range: str = ""  # "INT in [0 - 9]", "POSITIVE"
    default: str = ""
    required: bool = False
    repeated: bool = False
    needs: list = field(default_factory=list)
    excludes: list = field(default_factory=list)
    text: str = ""


@dataclass
class Verb:
    name: str  # "" of the command itself
    summary: str = ""
    usage: str = ""
    positionals: list = field(default_factory=list)
    options: list = field(default_factory=list)
    verbs: list = field(default_factory=list)  # of the command: names
    footer: str = ""


def rows_of(lines):
    """(left, description) of each entry of a section; a left part that is too long has its description in the next line."""
    rows = []
    for line, following in zip(lines, lines[1:] + [""]):
        if line.startswith(" " * WIDTH):
            rows[-1] = (rows[-1][0], f"{rows[-1][1]} {line.strip()}".strip())
        elif following.startswith(" " * WIDTH) or len(line) <= WIDTH:
            rows.append((line.strip(), ""))
        else:
            rows.append((line[:WIDTH].strip(), line[WIDTH:].strip()))
    return rows


def enumerated(text):
    """The words of "Only those: block, process or sink", of '"plugin" or "filter"' and of "…, as nc,csv,page"; else none."""
    part = re.sub(r"^.*(: |, as )", "", text)
    words = re.split(r",\s*|\s+or\s+", part)
    if all(re.fullmatch(r'"[a-z_]+"', word) for word in words):
        return [word.strip('"') for word in words]
    return words if len(words) > 2 and all(re.fullmatch(r"[a-z_]+", word) for word in words) else []


def entry_of(left, text):
    names, _, rest = left.partition(" ")
    entry = Entry(names.split(","), text=text)
    rest, *relations = re.split(r"\s?(?=\b(?:Needs|Excludes): )", rest)
    for relation in relations:
        kind, _, others = relation.partition(": ")
        (entry.needs if kind == "Needs" else entry.excludes).extend(others.split())
    entry.required = bool(re.search(r"(^| )REQUIRED$", rest))
    rest = re.sub(r"(^| )REQUIRED$", "", rest)
    entry.repeated = rest.endswith(" ...")
    rest = rest.removesuffix(" ...")
    if default := re.search(r"=([^A-Z=][^=]*)$", rest):
        entry.default, rest = default[1], rest[: default.start()]
    if choices := re.search(r":\{(.*)\}$", rest):
        entry.choices, rest = choices[1].split(","), rest[: choices.start()]
    elif kind := re.search(r":([A-Z]+ in \[.*\]|POSITIVE)$", rest):
        entry.range, rest = kind[1], rest[: kind.start()]
    if not entry.names[0].startswith("-"):
        rest = rest.removeprefix("TEXT").strip()
        entry.value = entry.names[0]
    entry.value = entry.value or rest
    entry.choices = entry.choices or enumerated(text)
    return entry


def sections_of(text):
    """Title, and lines, of what stands below lines such as "Options:"; "" is what stands before the first."""
    sections, title = {"": []}, ""
    for line in text.splitlines():
        if re.fullmatch(r"[A-Z][a-z]+:", line):
            title = line[:-1]
            sections[title] = []
        elif not line.strip() and title in ("Options", "Subcommands"):
            title = f"after {title}"
            sections.setdefault(title, [])
        elif line.strip():
            sections[title].append(line)
    return sections


def parse(name, text):
    sections = sections_of(text)
    verb = Verb(name)
    for line in sections[""]:
        if line.startswith("Usage: "):
            verb.usage = line.removeprefix("Usage: ")
        elif not verb.usage:
            verb.summary = f"{verb.summary} {line}".strip()
    verb.positionals = [entry_of(*row) for row in rows_of(sections.get("Positionals", []))]
    verb.options = [entry_of(*row) for row in rows_of(sections.get("Options", []))]
    verb.verbs = [left for left, _ in rows_of(sections.get("Subcommands", []))]
    verb.footer = "\n".join(sections.get("after Subcommands", []) or sections.get("after Options", []))
    if not verb.summary or not verb.usage or not verb.options:
        raise SystemExit(f"help_text.py: 'binnacle {name} --help' is not understood:\n{text}")
    return verb


def read(command):
    """The command itself, and all its verbs, of the program `command`."""

    def help_of(*words):
        return subprocess.run([command, *words, "--help"], capture_output=True, text=True, check=True).stdout

    main = parse("", help_of())
    if not main.verbs:
        raise SystemExit("help_text.py: 'binnacle --help' lists no verbs")
    return main, [parse(name, help_of(name)) for name in main.verbs]


def action_of(entry):
    """How the value of an option, or a positional, is completed: config, type, directory, library, file, choice or none."""
    value = entry.value
    if value == "CONFIG":
        return "config"
    if value == "TYPE":
        return "type"
    if value == "DIR":
        return "directory"
    if value == "LIBRARY":
        return "library"
    if entry.choices:
        return "choice"
    if value.startswith("FILE") or "=PATH" in value or re.search(r"\bthis file\b", entry.text):
        return "file"
    return "none"
