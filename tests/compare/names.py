# SPDX-License-Identifier: Apache-2.0
"""The table of old and new names, renames.json, and how it applies to paths, words of a command line, keys and columns."""
import json
import re

TABLES = ("configs", "arguments", "files", "pointers", "names", "parts")
SEPARATORS = re.compile(r"([/.\[\] ])")


class Bad(Exception):
    """A table that cannot be used, with the reason."""


def read_json(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except (OSError, ValueError) as error:
        raise Bad(f"{path}: {error}")


def tokens_of(pointer):
    return tuple(token.replace("~1", "/").replace("~0", "~") for token in pointer.split("/")[1:])


def pointer_of(tokens):
    return "".join("/" + str(token).replace("~", "~0").replace("/", "~1") for token in tokens)


def fits(text, pattern):
    """* is any text, and nothing else is special: a column is called position.lat[rad]."""
    return re.fullmatch(".*".join(re.escape(piece) for piece in pattern.split("*")), text, re.DOTALL) is not None


class Renames:
    """Old names to new ones. `used` collects the entries that applied to something."""

    def __init__(self, table, used=None):
        self.used = set() if used is None else used
        unknown = set(table) - set(TABLES) - {"only"}
        if unknown:
            raise Bad(f"renames.json: unknown table {', '.join(sorted(unknown))}")
        self.table = {kind: dict(table.get(kind, {})) for kind in TABLES}
        self.only = table.get("only", [])
        self.pointers = []
        for old, new in self.table["pointers"].items():
            if old.count("*") != new.count("*"):
                raise Bad(f"renames.json: '{old}' and '{new}' have different numbers of *")
            self.pointers.append((tokens_of(old), tokens_of(new), old))
        self.pointers.sort(key=lambda rule: -len(rule[0]))

    @classmethod
    def read(cls, path):
        return cls(read_json(path))

    def of_config(self, config):
        """With the tables that hold for this config only merged in."""
        merged = {kind: dict(self.table[kind]) for kind in TABLES}
        for entry in self.only:
            if fits(config, entry["config"]):
                for kind in TABLES:
                    merged[kind].update(entry.get(kind, {}))
        return Renames(merged, self.used)

    def entries(self):
        for table in [self.table] + self.only:
            for kind in TABLES:
                for old in table.get(kind, {}):
                    yield kind, old

    def _map(self, kind, old):
        if old not in self.table[kind]:
            return None
        self.used.add((kind, old))
        return self.table[kind][old]

    def config(self, path):
        new = self._map("configs", path)
        return path if new is None else new

    def file(self, name):
        folder, _, base = name.rpartition("/")
        new = self._map("files", base)
        base = base if new is None else new
        return f"{folder}/{base}" if folder else base

    def argument(self, word):
        new = self._map("arguments", word)
        if new is not None:
            return new
        name, equals, value = word.partition("=")
        new = self._map("arguments", name) if equals else None
        return word if new is None else f"{new}={value}"

    def name(self, name):
        """A key, a column or a cell: as a whole, else part by part between / . [ ] and blanks."""
        new = self._map("names", name)
        if new is not None:
            return new
        if not self.table["parts"]:
            return name
        pieces = SEPARATORS.split(name)
        for at, piece in enumerate(pieces):
            new = self._map("parts", piece)
            if new is not None:
                pieces[at] = new
        return "".join(pieces)

    def underscored(self, name):
        """The name of a NetCDF variable, where _ stands for every separator."""
        new = self._map("names", name)
        if new is not None:
            return new
        for old, new in self.table["parts"].items():
            name, count = re.subn(rf"(?<![A-Za-z0-9]){re.escape(old)}(?![A-Za-z0-9])", lambda _: new, name)
            if count:
                self.used.add(("parts", old))
        return name

    def tokens(self, tokens):
        """Where a value of the old summary stands in the new one."""
        moved, rest = (), tokens
        for old, new, entry in self.pointers:
            if len(old) <= len(tokens) and all(o == "*" or o == str(t) for o, t in zip(old, tokens)):
                self.used.add(("pointers", entry))
                stars = [self.name(str(t)) for o, t in zip(old, tokens) if o == "*"]
                moved = tuple(stars.pop(0) if n == "*" else n for n in new)
                rest = tokens[len(old):]
                break
        return moved + tuple(t if isinstance(t, int) else self.name(t) for t in rest)


class Allowed:
    """differences.json: differences that a defect explains. Every entry must explain something."""

    KEYS = {"config", "verb", "place", "at_most", "reason"}

    def __init__(self, entries):
        self.entries = entries
        self.explained = [0] * len(entries)
        self.judged = [False] * len(entries)
        for entry in entries:
            if not {"config", "place", "reason"} <= set(entry) <= self.KEYS or not entry["reason"].strip():
                raise Bad(f"differences.json: an entry has config, place, reason, and may have verb, at_most: {entry}")

    @classmethod
    def read(cls, path):
        return cls(read_json(path))

    def _holds_for(self, entry, config, verb):
        return fits(config, entry["config"]) and fits(verb, entry.get("verb", "*"))

    def judge(self, config, verb):
        """The numbers of this config were compared: entries for it have their chance now."""
        for at, entry in enumerate(self.entries):
            self.judged[at] = self.judged[at] or self._holds_for(entry, config, verb)

    def explains(self, config, verb, difference):
        found = False
        for at, entry in enumerate(self.entries):
            if not self._holds_for(entry, config, verb) or not fits(difference.place, entry["place"]):
                continue
            if "at_most" in entry and not (difference.relative is not None and difference.relative <= entry["at_most"]):
                continue
            self.explained[at] += 1
            found = True
        return found

    def idle(self):
        """Entries that had their chance and explain nothing."""
        return [e for e, n, j in zip(self.entries, self.explained, self.judged) if j and n == 0]

    def unjudged(self):
        return [e for e, j in zip(self.entries, self.judged) if not j]
