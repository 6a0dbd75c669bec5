# SPDX-License-Identifier: Apache-2.0
"""Results as pandas and xarray have them. Both are imported when they are asked for, and only then."""

import re

import numpy as np

FILL_OF_KEYS = np.int64(-9223372036854775806)


def _imported(name):
    try:
        return __import__(name)
    except ImportError as error:
        package = f"the Debian package python3-{name}, or pip install {name}"
        raise ImportError(f"to_{'pandas' if name == 'pandas' else 'xarray'}() needs {name}: {package}") from error


# pandas


def _time_index(t):
    return _imported("pandas").Index(t, name="t")


def records_frame(t, values, columns):
    frame = _imported("pandas").DataFrame(values, index=_time_index(t), columns=[name for name, _ in columns], copy=False)
    frame.attrs["units"] = dict(columns)
    return frame


def error_frame(name, series):
    columns = {"error": np.asarray(series)}
    if series.sigma is not None:
        columns["sigma"] = series.sigma
    frame = _imported("pandas").DataFrame(columns, index=_time_index(series.t))
    frame.attrs["units"] = dict.fromkeys(columns, series.units)
    return frame


def innovation_frames(innovations):
    pandas = _imported("pandas")
    samples = {name: getattr(innovations, name) for name in ("outcome", "reason", "nis", "rows")}
    samples = pandas.DataFrame(samples, index=_time_index(innovations.t))
    names = np.asarray([name for name, _ in innovations.groups] or [""])
    rows = {"sample": innovations.sample, "t": innovations.t[innovations.sample], "group": names[innovations.group]}
    rows.update({name: getattr(innovations, name) for name in ("key", "residual", "sigma", "noise")})
    rows = pandas.DataFrame(rows)
    rows.attrs["units"] = dict(innovations.groups)
    return samples, rows


def study_frame(study):
    pandas = _imported("pandas")
    frames = {name: pandas.DataFrame(dict(metrics.items()), index=range(study.runs)) for name, metrics in study.items()}
    frame = pandas.concat(frames, names=["variant", "run"])
    frame.attrs["units"] = {name: unit for metrics in study.values() for name, unit in metrics.units.items()}
    return frame


# xarray: the groups, variables and coordinates of run.nc


def _identifier(text):
    name = re.sub(r"[^a-zA-Z0-9]", "_", text)
    return name if name and not name[0].isdigit() else "_" + name


class _NamesOf:
    """Of one group: "fix", and "fix_2" for the second thing of that name, as run.nc has them."""

    def __init__(self, *taken):
        self._taken = set(taken)

    def take(self, text):
        wanted = name = _identifier(text)
        n = 2
        while name in self._taken:
            name, n = f"{wanted}_{n}", n + 1
        self._taken.add(name)
        return name


def _attributes(unit, display_unit, **more):
    attributes = {"units": unit} if unit else {}
    if display_unit and display_unit != unit:
        attributes["display_units"] = display_unit
    return {**attributes, **{name: text for name, text in more.items() if text}}


def _is_one_variable(units, display_units):
    return len(units) > 1 and len(set(units)) == 1 and len(set(display_units)) == 1


def _estimates(filter):
    names = _NamesOf("errors", "measurements", "time")
    variables, coordinates = {}, {"time": ("time", filter.t, {"units": "s"})}

    def add(name, dimensions, series, column, **more):
        name, sigma_name = names.take(name), names.take(name + "_sigma")
        values, sigma = np.asarray(series)[:, column], np.asarray(series.sigma)[:, column]
        first = 0 if isinstance(column, slice) else column
        attributes = _attributes(series.units[first], series.display_units[first], **more)
        variables[name] = (dimensions, values, {**attributes, "ancillary_variables": sigma_name})
        variables[sigma_name] = (dimensions, sigma, attributes)

    for block, series in filter.items():
        if _is_one_variable(series.units, series.display_units):
            component = names.take(block + "_component")
            coordinates[component] = (component, series.names)
            add(block, ("time", component), series, slice(None), block=block)
        else:
            for i, output in enumerate(series.names):
                add(f"{block}_{output}", ("time",), series, i, block=block, output=output)
    for name, series in filter.others.items():
        variables[names.take(name)] = ("time", np.asarray(series), _attributes(series.units, "", column=name))
        if series.sigma is not None:
            attributes = _attributes(series.units, "", column=name + ".sigma")
            variables[names.take(name + "_sigma")] = ("time", series.sigma, attributes)
    return _imported("xarray").Dataset(variables, coordinates, {"filter": filter.name})


class _ErrorTimes:
    """Errors at the same times share a dimension."""

    def __init__(self, names, coordinates):
        self._names, self._coordinates, self._bases = names, coordinates, []

    def dimension(self, name, t):
        for base, times in self._bases:
            if np.array_equal(times, t):
                return base
        base = self._names.take("time_" + name if self._bases else "time")
        self._bases.append((base, t))
        self._coordinates[base] = (base, t, {"units": "s"})
        return base


def _add_error(variables, names, name, dimensions, values, sigma, attributes):
    own = names.take(name)
    variables[own] = (dimensions, values, attributes)
    if sigma is not None:
        sigma_name = names.take(name + "_sigma")
        variables[sigma_name] = (dimensions, sigma, dict(attributes))
        attributes["ancillary_variables"] = sigma_name


def _errors(filter):
    """Components of a block's error at the same times are one variable."""
    names, variables, coordinates, blocks = _NamesOf(), {}, {}, {}
    times = _ErrorTimes(names, coordinates)
    for name, series in filter.errors.items():
        dimension, (block, _, component) = times.dimension(name, series.t), name.rpartition(".")
        if name in filter.errors.components and blocks.setdefault(block, (dimension, []))[0] == dimension:
            blocks[block][1].append((component, series))
            continue
        attributes = _attributes(series.units, series.display_units)
        _add_error(variables, names, name, (dimension,), np.asarray(series), series.sigma, attributes)
    for block, (dimension, parts) in blocks.items():
        component = names.take(block + "_component")
        coordinates[component] = (component, [name for name, _ in parts])
        first = parts[0][1]
        sigma = None if first.sigma is None else np.column_stack([series.sigma for _, series in parts])
        attributes = _attributes(first.units, first.display_units, block=block)
        values = np.column_stack([np.asarray(series) for _, series in parts])
        _add_error(variables, names, block, (dimension, component), values, sigma, attributes)
    return _imported("xarray").Dataset(variables, coordinates)


def _slots(innovations, mask):
    """Of the rows of one group: the place of each among those of its sample."""
    sample = innovations.sample[mask]
    begins = np.searchsorted(sample, sample, side="left")
    return sample, np.arange(len(sample)) - begins


def _rows(innovations, g, suffix):
    """Of one group: (time, row), as wide as the largest sample; where a sample has none NaN, or NetCDF's fill value."""
    (group, unit), mask = innovations.groups[g], innovations.group == g
    sample, slot = _slots(innovations, mask)
    shape, dimensions = (len(innovations.t), int(slot.max()) + 1 if len(slot) else 0), ("time", "row" + suffix)
    fields = {"residual": innovations.residual, "residual_sigma": innovations.sigma, "noise": innovations.noise}
    for name, numbers in {**fields, "key": innovations.key}.items():
        wide = np.full(shape, FILL_OF_KEYS) if name == "key" else np.full(shape, np.nan)
        wide[sample, slot] = numbers[mask]
        beside = f"residual_sigma{suffix} noise{suffix} key{suffix}" if name == "residual" else ""
        attributes = _attributes("" if name == "key" else unit, "", row_group=group, ancillary_variables=beside)
        yield name + suffix, (dimensions, wide, attributes)


def _measurement(innovations):
    outcomes = innovations.outcomes
    flags = {"flag_values": np.arange(len(outcomes), dtype=np.int8), "flag_meanings": " ".join(outcomes)}
    texts, reason = innovations.reason_texts()
    variables = {
        "outcome": ("time", innovations.outcome_code, flags),
        "reason": ("time", reason),
        "reason_text": ("reason_text", texts),
        "nis": ("time", innovations.nis, {"units": "1"}),
        "rows": ("time", innovations.rows),
    }
    names = _NamesOf()
    for g, (group, _) in enumerate(innovations.groups):
        variables.update(_rows(innovations, g, names.take("_" + _identifier(group)) if len(innovations.groups) > 1 else ""))
    time = {"time": ("time", innovations.t, {"units": "s"})}
    return _imported("xarray").Dataset(variables, time, {"measurement": innovations.name})


def filter_datasets(filter):
    datasets = {"": _estimates(filter)}
    if filter.errors:
        datasets["errors"] = _errors(filter)
    names = _NamesOf()
    for name, innovations in filter.innovations.items():
        datasets["measurements/" + names.take(name)] = _measurement(innovations)
    return datasets


def study_dataset(study):
    xarray, names = _imported("xarray"), _NamesOf("variant", "run", "state")
    metrics = {name: metrics.units[name] for metrics in study.values() for name in metrics}
    variables = {}
    for name, unit in metrics.items():
        values = [metrics[name] if name in metrics else np.full(study.runs, np.nan) for metrics in study.values()]
        variables[names.take(name)] = (("variant", "run"), np.array(values), _attributes(unit, "", long_name=name))
    return xarray.Dataset(variables, {"variant": list(study), "run": np.arange(study.runs)})
