# SPDX-License-Identifier: Apache-2.0
# Reads a run's folder by HDF5 alone, without NetCDF, and holds run.nc against the CSV and the summary.
import csv
import json
import pathlib
import sys

import h5py
import numpy


def text(value):
    if isinstance(value, numpy.ndarray):
        value = value.flat[0]
    return value.decode() if isinstance(value, bytes) else str(value)


def texts(variable):
    """A variable of characters; its last dimension is the length."""
    return [row.tobytes().rstrip(b"\0").decode() for row in variable[()].reshape(-1, variable.shape[-1])]


def dimensions(variable):
    return [text(axis[0].name).rsplit("/", 1)[-1] for axis in variable.dims]


def same_bits(a, b, what):
    a, b = numpy.asarray(a, "<f8"), numpy.asarray(b, "<f8")
    assert a.shape == b.shape, f"{what}: {a.shape} and {b.shape}"
    assert a.tobytes() == b.tobytes(), f"{what}: other numbers"


def as_stated(exact, read, name, unit):
    """Within half a unit of the last digit that results.md states."""
    exact, read = numpy.asarray(exact), numpy.asarray(read)
    magnitude = numpy.floor(numpy.log10(numpy.where(exact == 0, 1, abs(exact))))
    if name.endswith((".sigma", ".noise")):
        unit_of_last = 10.0 ** (magnitude - 4)
    else:
        decimals = {"rad": 11, "m": 4, "m/s": 6, "rad/s": 9, "m/s^2": 7, "1": 9, "s": 12}[unit]
        unit_of_last = numpy.minimum(10.0 ** -decimals, 10.0 ** (magnitude - 5))
    assert exact.shape == read.shape, f"{name}: {exact.shape} and {read.shape}"
    assert (abs(exact - read) <= 0.5001 * unit_of_last + 1e-16 * abs(exact)).all(), f"{name}: other numbers"


def column_of(group, name):
    """The values and the unit of 'block.output' or 'block.output.sigma', the way the guide describes."""
    block, output, *sigma = name.split(".")
    suffix = "_sigma" if sigma else ""
    if f"{block}_{output}{suffix}" in group:
        variable = group[f"{block}_{output}{suffix}"]
        assert dimensions(variable) == ["time"], name
        return variable[:], text(variable.attrs["units"])
    variable = group[f"{block}{suffix}"]
    assert dimensions(variable) == ["time", f"{block}_component"], name
    components = texts(group[f"{block}_component"])
    return variable[:, components.index(output)], text(variable.attrs["units"])


def check_estimates(group, path):
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    columns = {}
    for name, values in zip(header, zip(*rows)):
        name, unit = name.rstrip("]").split("[")
        columns[name] = ([float(value) for value in values], unit)
    times, unit = columns.pop("t")
    same_bits(group["time"][:], times, "time")
    assert text(group["time"].attrs["units"]) == unit == "s"
    for name, (values, unit) in columns.items():
        found, units = column_of(group, name)
        as_stated(found, values, name, unit)
        assert units == unit, f"{name}: {units}, not {unit}"
    return len(columns)


def check_measurement(group, summary):
    outcome = group["outcome"]
    names = text(outcome.attrs["flag_meanings"]).split()
    values = list(outcome.attrs["flag_values"])
    assert len(names) == len(values) == 7
    assert outcome.dtype == numpy.int8
    offered = outcome[:]
    assert len(offered) == summary["offered"]
    for name, value in zip(names, values):
        assert (offered == value).sum() == summary[name], name
    nis = group["nis"][:][offered == values[names.index("accepted")]]
    assert abs(nis.mean() - summary["nis_mean"]) < 1e-12 * summary["nis_mean"]
    rows = 0
    for name, variable in group.items():
        if not name.startswith("residual") or "ancillary_variables" not in variable.attrs:
            continue
        suffix = name[len("residual"):]
        assert dimensions(variable) == ["time", "row" + suffix], dimensions(variable)
        assert text(variable.attrs["units"])
        assert variable.shape == group["residual_sigma" + suffix].shape == group["noise" + suffix].shape
        assert (group["residual_sigma" + suffix][:] >= group["noise" + suffix][:]).all()
        rows += numpy.isfinite(variable[:]).sum()
    assert rows == group["rows"][:].sum()


def check_errors(group, summary):
    span = summary["span"] if "span" in summary else None
    assert span is None
    time = group["time"][:]
    for name in ("position", "velocity"):
        variable = group[name]
        assert dimensions(variable) == ["time", f"{name}_component"]
        assert texts(group[f"{name}_component"]) == ["north", "east", "down"]
        assert text(variable.attrs["frame"]) == "north, east, down"
        # Scored from 10 s after the start on, as the config says.
        scored = variable[:][time >= summary["start_s"] + 10]
        for i, component in enumerate(("north", "east", "down")):
            figures = summary["reference"][f"{name}.{component}"]
            assert abs(numpy.sqrt((scored[:, i] ** 2).mean()) - figures["rms"]) < 1e-9 * figures["rms"]
            assert len(scored) == figures["n"]


folder = pathlib.Path(sys.argv[1])
with h5py.File(folder / "run.nc", "r") as file:
    summary = json.loads((folder / "summary.json").read_text())
    assert json.loads(texts(file["config"])[0]) == json.loads((folder / "config.json").read_text())
    assert text(file.attrs["Conventions"]) == "CF-1.10"
    assert file.attrs["seed"] == summary["seed"]
    assert text(file.attrs["command"]).startswith("binnacle run ")
    assert {"core", "phi_error"} <= set(texts(file["plugin"]))
    compared = 0
    for name, filter_summary in summary["filters"].items():
        compared += check_estimates(file[name], folder / f"{name}.csv")
        check_errors(file[name]["errors"], filter_summary)
        for measurement, figures in filter_summary["measurements"].items():
            check_measurement(file[name]["measurements"][measurement], figures)
print(compared, "columns are the same")
