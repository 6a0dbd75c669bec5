# SPDX-License-Identifier: Apache-2.0
# Reads a study's folder by HDF5 alone, without NetCDF, and holds study.nc against the CSV and the figures.
import csv
import json
import math
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


folder = pathlib.Path(sys.argv[1])
figures = json.loads((folder / "study.json").read_text())
with h5py.File(folder / "study.nc", "r") as file:
    variants = texts(file["variant"])
    assert variants == list(figures["variants"])
    assert list(file["run"][:]) == list(range(figures["runs"]))
    metrics = {text(v.attrs["metric"]): v for v in file.values() if "metric" in v.attrs}
    compared = 0
    with open(folder / "study.csv", newline="") as rows:
        for row in csv.DictReader(rows):
            variable = metrics[row["metric"]]
            assert variable.shape == (len(variants), figures["runs"])
            value = variable[variants.index(row["variant"]), int(row["run"])]
            state = file["state"][variants.index(row["variant"]), int(row["run"])]
            shown = text(variable.attrs.get("display_units", variable.attrs["units"]))
            assert shown == row["unit"]
            assert (state == 1) == (row["value"] == "")
            if row["value"] == "":
                assert math.isnan(value)
            elif shown == text(variable.attrs["units"]):
                assert value == float(row["value"])
            else:
                scale = {"deg": math.pi / 180, "mil": 2 * math.pi / 6400}[shown]
                assert abs(value - float(row["value"]) * scale) <= 1e-12 * abs(value)
            compared += 1
    tables = figures.get("tables", [figures["table"]] if "table" in figures else [])
    for number, table in enumerate(tables, 1):
        group = file[f"tables/table_{number}"]
        assert text(group.attrs["title"]) == table["title"]
        assert texts(group["row"]) == table["rows"]
        assert texts(group["column"]) == table["columns"]
        cell_texts, units = texts(group["text"]), texts(group["unit"])
        for r, cells in enumerate(table["cells"]):
            for c, cell in enumerate(cells):
                if isinstance(cell, str):
                    assert cell_texts[r * len(cells) + c] == cell
                else:
                    assert group["value"][r, c] == cell or (cell is None and math.isnan(group["value"][r, c]))
                assert units[r * len(cells) + c] == table["units"][r][c]
print(compared, "values are the same")
