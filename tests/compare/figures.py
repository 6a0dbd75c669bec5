# SPDX-License-Identifier: Apache-2.0
"""What two commands left behind, compared number by number and to the bit."""
import csv
import json
import re
import struct
from pathlib import Path

import netcdf
from names import pointer_of

# How long the machine took: never the same twice. Old names; renames apply.
MACHINE_TIMES = {"wall_s", "filter_s"}
# No numbers of a result: the page, the config as it was run, the journal that lets a study go on.
NOT_COMPARED = {"report.html", "config.json", "study.journal"}
# Where text is more than wording: what a number is counted in.
UNITS = {"unit", "units"}
# Columns of a CSV that hold wording.
WORDING_COLUMNS = {"table"}
CODE = re.compile(r"\b(?:error|warning|note)\[([A-Z]\d+)\]")


class Number(str):
    """A JSON number as it is written."""


class Difference:
    def __init__(self, place, old, new, relative=None, count=1):
        self.place, self.old, self.new, self.relative, self.count = place, old, new, relative, count

    def __str__(self):
        size = "" if self.relative is None else f", relative {self.relative:.2g}"
        more = "" if self.count == 1 else f", {self.count} in all"
        return f"{self.place}: {self.old} -> {self.new}{size}{more}"


class Result:
    """values: numbers that were compared. wording: texts that differ and are no numbers."""

    def __init__(self):
        self.values = 0
        self.wording = 0
        self.differences = []
        self.unread = []

    def differ(self, *arguments, **named):
        self.differences.append(Difference(*arguments, **named))


def as_float(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def same_number(old, new):
    """Equal to the bit. Text that differs may stand for the same double: 2 and 2.0, but not 0 and -0."""
    if old == new:
        return True
    try:
        return int(old) == int(new) and not (old.startswith("-0") or new.startswith("-0"))
    except ValueError:
        pass
    a, b = as_float(old), as_float(new)
    return a is not None and b is not None and struct.pack("<d", a) == struct.pack("<d", b)


def relative_size(old, new):
    a, b = as_float(old), as_float(new)
    if a is None or b is None:
        return None
    largest = max(abs(a), abs(b))
    return abs(a - b) / largest if 0 < largest < float("inf") else 0.0 if a == b else None


def larger(a, b):
    """None, a size that is not known, outweighs all."""
    return None if a is None or b is None else max(a, b)


def codes_in(text):
    return CODE.findall(text)


# JSON -----------------------------------------------------------------------------------------------------------------

def leaves(value, tokens=()):
    """(tokens, leaf) of everything that is not an object or list; an empty one of either is a leaf too."""
    if isinstance(value, dict) and value:
        for key, inner in value.items():
            yield from leaves(inner, tokens + (key,))
    elif isinstance(value, list) and value and tokens[-1:] == ("warnings",):
        yield tokens, [codes_in(str(entry)) for entry in value]
    elif isinstance(value, list) and value:
        for at, inner in enumerate(value):
            yield from leaves(inner, tokens + (at,))
    else:
        yield tokens, value


def read_json(path):
    text = Path(path).read_text(encoding="utf-8")
    return json.loads(text, parse_float=Number, parse_int=Number, parse_constant=Number)


def show(value):
    return value if isinstance(value, str) else json.dumps(value)


def compare_leaf(result, place, old, new, is_unit, renames):
    if isinstance(old, Number) and isinstance(new, Number):
        result.values += 1
        if not same_number(old, new):
            result.differ(place, old, new, relative_size(old, new))
    elif type(old) is not type(new):
        result.differ(place, show(old), show(new))
    elif isinstance(old, str):
        if old == new:
            return
        if is_unit:
            if renames.name(old) != new:
                result.differ(place, old, new)
        else:
            result.wording += 1
    elif isinstance(old, list) and old:  # codes of warnings
        if [[renames.name(code) for code in codes] for codes in old] != new:
            result.differ(place, show(old), show(new))
    elif old != new:
        result.differ(place, show(old), show(new))


def compare_json(result, name, old_path, new_path, renames):
    times = MACHINE_TIMES | {renames.name(key) for key in MACHINE_TIMES}
    new = {tokens: leaf for tokens, leaf in leaves(read_json(new_path)) if not times & {str(t) for t in tokens}}
    seen = {}
    for tokens, leaf in leaves(read_json(old_path)):
        if MACHINE_TIMES & {str(t) for t in tokens}:
            continue
        place, mapped = f"{name}#{pointer_of(tokens)}", renames.tokens(tokens)
        if mapped in seen:
            result.differ(place, f"has the new name of {seen[mapped]} too", pointer_of(mapped))
        elif mapped not in new:
            result.differ(place, show(leaf), "missing")
        else:
            compare_leaf(result, place, leaf, new[mapped], any(t in UNITS for t in tokens), renames)
        seen[mapped] = place
    for tokens, leaf in new.items():
        if tokens not in seen:
            result.differ(f"{name}#{pointer_of(tokens)}", "missing", show(leaf))


# CSV ------------------------------------------------------------------------------------------------------------------

def same_cell(old, new, renames):
    return old == new or (as_float(old) is not None and same_number(old, new)) or \
        (as_float(old) is None and renames.name(old) == new)


def compare_csv(result, name, old_path, new_path, renames):
    with open(old_path, newline="", encoding="utf-8") as old_file, open(new_path, newline="", encoding="utf-8") as new_file:
        old_rows, new_rows = csv.reader(old_file), csv.reader(new_file)
        header, new_header = next(old_rows, []), next(new_rows, [])
        mapped = [renames.name(column) for column in header]
        if len(set(mapped)) < len(mapped) or len(set(new_header)) < len(new_header):
            result.differ(f"{name}#columns", "two columns of one name", ", ".join(mapped))
            return
        for column, to in zip(header, mapped):
            if to not in new_header:
                result.differ(f"{name}#{column}", "there", "missing")
        for column in new_header:
            if column not in mapped:
                result.differ(f"{name}#{column}", "missing", "there")
        pairs = [(at, new_header.index(to)) for at, to in enumerate(mapped) if to in new_header]
        is_in_place = mapped == new_header
        first, counts, largest, old_count, new_count = {}, {}, {}, 0, 0
        for old in old_rows:
            old_count += 1
            new = next(new_rows, None)
            if new is None:
                old_count += sum(1 for _ in old_rows)
                break
            new_count += 1
            result.values += len(pairs)
            if is_in_place and old == new:
                continue
            if len(old) != len(header) or len(new) != len(new_header):
                result.differ(f"{name}#row {old_count}", f"{len(old)} cells", f"{len(new)} cells")
                continue
            for at, to in pairs:
                if same_cell(old[at], new[to], renames):
                    continue
                if header[at] in WORDING_COLUMNS:
                    result.wording += 1
                    continue
                first.setdefault(at, (old_count, old[at], new[to]))
                counts[at] = counts.get(at, 0) + 1
                largest[at] = larger(largest.get(at, 0.0), relative_size(old[at], new[to]))
        new_count += sum(1 for _ in new_rows)
        for at, (row, was, now) in sorted(first.items()):
            result.differ(f"{name}#{header[at]}", f"{was} (row {row})", now, largest[at], counts[at])
        if old_count != new_count:
            result.differ(f"{name}#rows", str(old_count), str(new_count))


# NetCDF ---------------------------------------------------------------------------------------------------------------

def compare_variable(result, place, old, new, renames):
    if renames.name(old.units) != new.units:
        result.differ(f"{place}:units", old.units, new.units)
    if (old.kind, old.shape) != (new.kind, new.shape):
        result.differ(place, f"type {old.kind}, {list(old.shape)}", f"type {new.kind}, {list(new.shape)}")
        return
    was, now = old.values(), new.values()
    result.values += len(was)
    if old.data == new.data:
        return
    size = netcdf.SIZES[old.kind]
    unequal = [at for at in range(len(was)) if old.data[at * size:(at + 1) * size] != new.data[at * size:(at + 1) * size]]
    at = unequal[0]
    largest = 0.0
    for i in unequal:
        largest = larger(largest, relative_size(repr(was[i]), repr(now[i])))
    result.differ(place, f"{was[at]!r} (value {at})", repr(now[at]), largest, len(unequal))


def compare_netcdf(result, name, old_path, new_path, renames, lib):
    if lib is None:
        result.unread.append(f"{name}: no NetCDF library")
        return
    old, new, seen = netcdf.read(lib, old_path), netcdf.read(lib, new_path), set()
    for path, variable in old.items():
        place = f"{name}#{pointer_of(path)}"
        mapped = tuple(renames.name(token) for token in path)
        if mapped not in new:
            mapped = tuple(renames.underscored(token) for token in path)
        if mapped not in new or mapped in seen:
            result.differ(place, "there", "missing")
            continue
        seen.add(mapped)
        compare_variable(result, place, variable, new[mapped], renames)
    for path in new:
        if path not in seen:
            result.differ(f"{name}#{pointer_of(path)}", "missing", "there")


# Folders --------------------------------------------------------------------------------------------------------------

def files_in(folder):
    found = {}
    for path in sorted(Path(folder).rglob("*")):
        if path.is_file() and path.name not in NOT_COMPARED and not path.name.startswith("."):
            found[path.relative_to(folder).as_posix()] = path
    return found


def compare_folders(old_folder, new_folder, renames, lib=None):
    result = Result()
    old, new, seen = files_in(old_folder), files_in(new_folder), set()
    for name, path in old.items():
        to = renames.file(name)
        if to not in new:
            result.differ(f"{name}#", "there", "missing")
            continue
        seen.add(to)
        if path.suffix == ".json":
            compare_json(result, name, path, new[to], renames)
        elif path.suffix == ".csv":
            compare_csv(result, name, path, new[to], renames)
        elif path.suffix == ".nc":
            compare_netcdf(result, name, path, new[to], renames, lib)
        else:
            result.unread.append(f"{name}: of no known kind")
    for name in new:
        if name not in seen:
            result.differ(f"{name}#", "missing", "there")
    return result
