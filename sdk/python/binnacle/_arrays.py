# SPDX-License-Identifier: Apache-2.0
"""Arrays as sources, in the place of files; samples of channels as arrays, in the place of sinks."""

import difflib
import hashlib
import json
from collections.abc import Mapping

import numpy as np

from . import _core
from ._results import Names

_TYPES = ("arrays", "numpy/arrays")
_LIKE_CSV = _TYPES + ("csv", "csv/csv")
_KINDS = ("level", "rate", "increment")
# Fields that mean the same in every plugin: unit and kind.
_STANDARD = {
    **dict.fromkeys(("wx", "wy", "wz"), ("rad/s", "rate")),
    **dict.fromkeys(("fx", "fy", "fz"), ("m/s^2", "rate")),
    **dict.fromkeys(("lat", "lon", "roll", "pitch", "yaw", "course"), ("rad", "level")),
    **dict.fromkeys(("height", "position_sd_n", "position_sd_e", "position_sd_d"), ("m", "level")),
    **dict.fromkeys(("vn", "ve", "vd", "speed", "velocity_sd_n", "velocity_sd_e", "velocity_sd_d"), ("m/s", "level")),
}


class Arrays:
    """Samples of one channel as arrays, for data= of load() and parse().

        bn.load("ins.json", data={"imu": bn.Arrays(t, {"wx": ("deg/s", gx), "fx": fx}, kind="rate")})

    t: (n,) times, seconds or numpy.timedelta64, increasing; the end of the interval of a rate or increment. fields:
    {name: array} (n,) in SI, or {name: ("deg/s", array)}; a pandas.DataFrame is such a mapping. Short for Arrays(t, fields) is
    (t, fields), for Arrays(t, fields, t0=t0) it is (t0, t, fields). A field whose unit neither the config's source of that
    name nor its own standard name (wx, fx, lat, vn, roll, speed, position_sd_n …) gives needs one, "1" where it has none.

    kind: "level", "rate" (mean over the interval that ends at t) or "increment" (integral over it), of all fields or by name.
    Default: what the config says of the field where it has a source of that name with "columns" (csv, numpy/arrays); else
    "rate" for wx wy wz fx fy fz, and for others with t0 or interval; "level" for what remains.
    t0: (n,) begins of the intervals, NaN or NaT where there is none; interval: their fixed length. Without either they reach
    from time to time, and max_gap (default: ten times the median step) leaves the sample after a longer step without one.
    units: {name: text}, in place of the pairs. missing: numbers that mean "no data", of all fields or by name,
    missing=[np.nan]; default: what the config's source says. Without it a NaN is refused, as in csv. What a
    numpy.ma.MaskedArray masks is missing.
    rows: the field that tells rows apart, or {"key", "max_rows"}: then t may repeat, and lines of one time are the rows of
    one sample.

    The numbers are copied once, when they are given to load() or parse(), and held as long as what was made of them; changing
    an array later changes nothing.
    """

    def __init__(self, t, fields, *, t0=None, kind=None, units=None, missing=None, interval=None, max_gap=None, rows=None):
        self.t, self.fields, self.t0, self.kind, self.units = t, fields, t0, kind, units
        self.missing, self.interval, self.max_gap, self.rows = missing, interval, max_gap, rows


def settings_of(data, resolved):
    """What data= becomes: settings for the config, and what has to be held until it is composed."""
    settings, held = {}, []
    sources = resolved.get("sources") if isinstance(resolved, dict) else None
    for name, given in data.items():
        source = sources.get(name) if isinstance(sources, dict) else None
        arrays, section = _Given(name, _spelt_out(name, given), source if isinstance(source, dict) else {}).made()
        settings["/sources/" + name.replace("~", "~0").replace("/", "~1")] = section
        held.append(arrays)
    return settings, held


def refuse_unused(data, resolved, loaded):
    """A name that is no source of the config, and whose channel nobody takes, is a slip."""
    sources = resolved.get("sources") or {}
    if not loaded.is_complete:
        return
    for name in data:
        if name in sources or loaded.subscribers(name):
            continue
        near = difflib.get_close_matches(name, {*sources, *loaded.channels} - {name}, 1)
        raise ValueError(f"data[{name!r}]: the config has no such source, and nothing in it takes channel {name!r}"
                         + (f"; did you mean {near[0]!r}?" if near else f"; it has the sources {_list(sources)}"))


def _spelt_out(name, given):
    if isinstance(given, Arrays):
        return given
    if isinstance(given, tuple) and len(given) == 2:
        return Arrays(given[0], given[1])
    if isinstance(given, tuple) and len(given) == 3:
        return Arrays(given[1], given[2], t0=given[0])
    raise TypeError(f"data[{name!r}] is a {type(given).__name__}: expected (t, fields), (t0, t, fields) or binnacle.Arrays")


class _Given:
    """The arrays of one source, checked, beside what the config says of it."""

    def __init__(self, name, arrays, source):
        self.what, self.arrays = f"data[{name!r}]", arrays
        self.source = source if source.get("type") in _LIKE_CSV else {}
        self.columns = self.source.get("columns") or {}
        self.is_ours = self.source.get("type") in _TYPES
        if not hasattr(arrays.fields, "items"):
            raise TypeError(f"{self.what}: fields is a {type(arrays.fields).__name__}; expected {{name: array}}")
        self.units, self.numbers, self.masked = {}, {}, set()
        for field, value in arrays.fields.items():
            self._take(field, value)

    def _take(self, field, value):
        unit = (self.arrays.units or {}).get(field)
        if isinstance(value, tuple) and len(value) == 2 and isinstance(value[0], str):
            if unit is not None:
                raise ValueError(f"{self.what}: field {field!r} has a unit in units and in its pair")
            unit, value = value
        numbers = np.asarray(value)
        if numbers.dtype.kind not in "fiu" and numbers.size:
            raise TypeError(f"{self.what}: field {field!r} has the type {numbers.dtype}; expected real numbers")
        self.units[field], self.numbers[field] = unit, np.ascontiguousarray(numbers, dtype=np.float64)
        if np.ma.is_masked(value):
            self.numbers[field] = np.where(np.ma.getmaskarray(value), np.nan, self.numbers[field])
            self.masked.add(field)

    def made(self):
        t, t0 = self._times()
        self._check(len(t))
        names = list(self.numbers)
        digest = hashlib.blake2b(digest_size=16)
        digest.update(json.dumps([names, t0 is not None]).encode())
        for numbers in (t, *([] if t0 is None else [t0]), *self.numbers.values()):
            digest.update(numbers)
        arrays = _core.array_data(digest.hexdigest(), names, t, t0, list(self.numbers.values()))
        return arrays, self._section(digest.hexdigest(), t0 is not None)

    def _times(self):
        t = _core.times(self.arrays.t, f"{self.what}: t", False)
        if self.arrays.t0 is None:
            return t, None
        t0 = _core.times(self.arrays.t0, f"{self.what}: t0", True)
        if len(t0) != len(t):
            raise ValueError(f"{self.what}: t0 has {len(t0)} times, t has {len(t)}")
        return t, t0

    def _check(self, count):
        if not self.numbers:
            raise ValueError(f"{self.what} has no field")
        for field, numbers in self.numbers.items():
            if numbers.shape != (count,):
                raise ValueError(
                    f"{self.what}: field {field!r} has the shape {numbers.shape}; with {count} times expected ({count},)"
                )
        lacking = [field for field in self.columns if field not in self.numbers]
        if lacking:
            has = _list(self.numbers)
            raise ValueError(f"{self.what} lacks the field {lacking[0]!r}, which the config's source has; it has {has}")
        for what in ("units", "kind", "missing"):
            by_name = getattr(self.arrays, what)
            unknown = [field for field in by_name if field not in self.numbers] if isinstance(by_name, Mapping) else []
            if unknown:
                raise ValueError(f"{self.what}: {what} names {unknown[0]!r}, which is no field; it has {_list(self.numbers)}")

    def _section(self, content, has_t0):
        arrays = self.arrays
        section = {"type": "numpy/arrays", "content": content,
                   "columns": {field: self._column(field, has_t0 or arrays.interval is not None) for field in self.numbers}}
        for key in ("interval", "max_gap"):
            value = getattr(arrays, key)
            if value is not None:
                section[key] = _seconds(value, f"{self.what}: {key}")
            elif self.is_ours and key in self.source and not (key == "interval" and has_t0):
                section[key] = self.source[key]
        rows = arrays.rows if arrays.rows is not None else self.source.get("rows")
        if rows is not None:
            section["rows"] = {"key": rows} if isinstance(rows, str) else rows
        return section

    def _column(self, field, has_intervals):
        stated = self.columns.get(field) or {}
        unit, kind = _STANDARD.get(field, (None, "rate" if has_intervals else "level"))
        column = {"unit": self.units[field] or self._stated_unit(stated) or unit,
                  "kind": _of(self.arrays.kind, field) or (stated.get("kind", "level") if stated else kind)}
        if column["unit"] is None:
            raise ValueError(
                f"{self.what}: field {field!r} needs a unit: {field!r}: (\"m/s\", array), or \"1\" where it has none"
            )
        if column["kind"] not in _KINDS:
            raise ValueError(f"{self.what}: kind of {field!r} is {column['kind']!r}; expected one of {_list(_KINDS)}")
        missing = _of(self.arrays.missing, field)
        missing = stated.get("missing") if missing is None else [repr(float(number)) for number in np.atleast_1d(missing)]
        missing = [text for text in missing or [] if _is_number(text)] + ["nan"] * (field in self.masked)
        if missing:
            column["missing"] = missing
        return column

    def _stated_unit(self, stated):
        """The config's: of the array where its source is one; of a file only its dimension, for arrays are in SI."""
        unit = stated.get("unit")
        return unit if unit is None or self.is_ours else _core.si_unit(unit)


def _of(value, field):
    return value.get(field) if isinstance(value, Mapping) else value


def _is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def _seconds(value, what):
    return str(int(_core.times([value], what, False)[0])) + " ns"


def _list(names):
    return ", ".join(map(repr, names)) or "none"


class Samples(Names):
    """Samples of a channel that a run kept: ["wx"] (n,) in SI; of a field per row (m,), through all samples.

    .t, .t0 (n,) [s], t0 NaN where a sample is an instant; .t_ns (n,), exact. .units {field: unit}. .kinds {field: "level",
    "rate" or "increment"}. .rows (n,): how many rows a sample has; .sample (m,): which sample a row is of. .covariance
    (n, d, d), in the order of .covariance_of, NaN where a sample had none; None where the channel attaches none.
    """

    _what = "field"

    def __init__(self, kept):
        fields = [(field[0], kept["values"][:, i]) for i, field in enumerate(kept["fields"])]
        fields += [(field[0], kept["row_values"][:, i]) for i, field in enumerate(kept["row_fields"])]
        super().__init__(fields)
        self.units = {name: unit for name, unit, _ in kept["fields"] + kept["row_fields"]}
        self.kinds = {name: kind for name, _, kind in kept["fields"] + kept["row_fields"]}
        self.t_ns = kept["t"]
        self.t = self.t_ns * 1e-9
        none = kept["t0"] == np.iinfo(np.int64).min
        self.t0 = np.where(none, np.nan, np.where(none, 0, kept["t0"]) * 1e-9)
        self.rows = kept["rows"]
        self.sample = np.repeat(np.arange(len(self.t)), self.rows)
        self.covariance_of = kept["covariance_of"]
        self.covariance = kept["covariances"] if self.covariance_of else None


class Keeper:
    """Compositions that also keep samples of channels; each serves one run at a time."""

    def __init__(self, loaded, load):
        self._loaded, self._load, self._idle = loaded, load, {}

    def run(self, keep, run):
        """run(loaded) with the channels of keep: what it returns, and {name: Samples}."""
        names = tuple([keep] if isinstance(keep, str) else dict.fromkeys(keep))
        idle = self._idle.setdefault(names, [])
        loaded, kept = idle.pop() if idle else self._made(names)
        result = run(loaded)
        samples = {name: Samples(of.take()) for name, of in zip(names, kept)}
        idle.append((loaded, kept))
        return result, samples

    def _made(self, names):
        known = self._loaded.channels
        for name in names:
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                raise KeyError(f"there is no channel {name!r}"
                               + (f"; did you mean {near[0]!r}?" if near else f"; there are {_list(known)}"))
        kept = [_core.KeptSamples() for _ in names]
        sinks = {f"/sinks/python_keep_{i}": {"type": "numpy/keep", "input": name, "into": kept[i].place()}
                 for i, name in enumerate(names)}
        return self._load(sinks), kept
