# SPDX-License-Identifier: Apache-2.0
"""Results of a folder, and as pandas and xarray have them."""

import copy
import csv
import pickle

import binnacle as bn
import numpy as np
import pytest

# Adapted noise and local coordinates are recorded beside the blocks.
SETS = {
    "/filters/ins/measurements/fix/noise": {"type": "beta_adapter", "hold": True},
    "/origin": {"lat": "48.137 deg", "lon": "11.575 deg", "height": "520 m"},
}


def same(a, b):
    """To the last bit, with their times, 1-sigma, names and units."""
    assert np.array_equal(np.ascontiguousarray(a).view(np.int64), np.ascontiguousarray(b).view(np.int64))
    assert np.array_equal(a.t, b.t) and (a.names, a.units, a.display_units) == (b.names, b.units, b.display_units)
    assert (a.sigma is None) == (b.sigma is None) and (a.sigma is None or np.array_equal(a.sigma, b.sigma, equal_nan=True))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("results") / "out"


@pytest.fixture(scope="module")
def run(project, folder):
    return bn.load(project / "configs" / "quickstart.json").run(seed=4, out=folder)


@pytest.fixture(scope="module")
def opened(run, folder):
    return bn.open(folder)


def test_a_folder_has_what_the_command_leaves(run, command, folder, tmp_path, monkeypatch):
    command("run", "configs/quickstart.json", "--seed", "4", "--out", tmp_path / "c", "--quiet")
    assert sorted(path.name for path in folder.iterdir()) == sorted(path.name for path in (tmp_path / "c").iterdir())
    assert (folder / "ins.csv").read_bytes() == (tmp_path / "c" / "ins.csv").read_bytes()
    assert (folder / "config.json").read_bytes() == (tmp_path / "c" / "config.json").read_bytes()


def test_what_is_opened_is_what_the_run_gave(run, opened, figures_of):
    assert isinstance(opened, bn.RunResult) and list(opened) == list(run)
    for name, filter in run.items():
        other = opened[name]
        assert list(filter) == list(other) and list(filter.errors) == list(other.errors)
        assert np.array_equal(filter.t_ns, other.t_ns)
        for block in filter:
            same(filter[block], other[block])
        for error in filter.errors:
            same(filter.errors[error], other.errors[error])
        assert filter.errors.components == other.errors.components
        for measurement, of_run in filter.innovations.items():
            of_file = other.innovations[measurement]
            for field in ("t", "outcome", "reason", "nis", "rows", "sample", "group", "key", "residual", "sigma", "noise"):
                a, b = getattr(of_run, field), getattr(of_file, field)
                assert np.array_equal(a, b, equal_nan=a.dtype == float), field
            assert of_run.groups == of_file.groups
    assert figures_of(dict(run.summary)) == figures_of(dict(opened.summary))
    assert (run.verdict, run.config) == (opened.verdict, opened.config)
    assert opened.provenance["seed"] == 4 and run.provenance is None


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))], ids=["copy", "deepcopy", "pickle"]
)
def test_copies_are_whole(run, copied):
    """multiprocessing hands results over by pickle."""
    other = copied(run)
    assert other.verdict == run.verdict and str(other.summary) == str(run.summary)
    yaw = run["ins"]["attitude.yaw"]
    same(other["ins"]["attitude.yaw"], yaw)
    same(other["ins"]["position"], run["ins"]["position"])
    for error in run["ins"].errors:
        same(other["ins"].errors[error], run["ins"].errors[error])
    np.testing.assert_array_equal(other["ins"].innovations["fix"].nis, run["ins"].innovations["fix"].nis)
    same(copied(yaw), yaw)
    same(yaw.copy(), yaw)


def test_exceptions_pass_between_processes():
    with pytest.raises(bn.ConfigError) as raised:
        bn.parse("{")
    error = pickle.loads(pickle.dumps(raised.value))
    assert str(error) == str(raised.value) and error.diagnostics == raised.value.diagnostics != []


def test_times_are_exact_and_in_seconds_the_nearest_double(run, folder):
    with open(folder / "ins.csv", newline="") as file:
        rows = list(csv.reader(file))
    ins = run["ins"]
    assert [row[0] for row in rows[1:]] == [f"{t // 10**9}.{t % 10**9:09}" for t in ins.t_ns.tolist()]
    assert np.array_equal(ins.t, [float(row[0]) for row in rows[1:]])


def test_a_frame_has_the_columns_of_the_csv(run, folder):
    pandas = pytest.importorskip("pandas")
    frame, of_file = run["ins"].to_pandas(), pandas.read_csv(folder / "ins.csv", index_col=0, float_precision="round_trip")
    assert [f"{name}[{frame.attrs['units'][name]}]" for name in frame.columns] == list(of_file.columns)
    # Of the CSV to the digits that results.md states; bit for bit they are those of run.nc, above.
    for name, unit in frame.attrs["units"].items():
        exact, read = frame[name].to_numpy(), of_file[f"{name}[{unit}]"].to_numpy()
        last = 10.0 ** (np.floor(np.log10(np.where(exact == 0, 1, abs(exact)))) - (4 if name.endswith(".sigma") else 5))
        if not name.endswith(".sigma"):
            last = np.minimum(last, 10.0 ** -{"rad": 11, "m": 4, "m/s": 6, "rad/s": 9, "m/s^2": 7}[unit])
        assert (abs(exact - read) <= 0.5001 * last + 1e-16 * abs(exact)).all(), name
    assert np.array_equal(frame.index, of_file.index)
    assert list(run.to_pandas()) == ["ins"]
    samples, rows = run["ins"].innovations["fix"].to_pandas()
    assert len(rows) == samples["rows"].sum()
    errors = run["ins"].errors.to_pandas()
    assert np.array_equal(errors["position.horizontal"]["error"], run["ins"].errors["position.horizontal"])


def test_datasets_are_those_of_run_nc(run, opened, folder):
    xarray = pytest.importorskip("xarray")
    for datasets in (run.to_xarray(), opened.to_xarray()):
        assert "ins" in datasets and "ins/errors" in datasets and "ins/measurements/fix" in datasets
        for group, dataset in datasets.items():
            of_file = xarray.open_dataset(folder / "run.nc", group=group)
            assert set(dataset.variables) == set(of_file.variables), group
            for name, variable in of_file.variables.items():
                own = dataset.variables[name]
                assert own.dims == variable.dims, name
                assert np.array_equal(own.values, variable.values, equal_nan=own.dtype == float), name
                for attribute in ("units", "display_units", "ancillary_variables", "block"):
                    assert own.attrs.get(attribute) == variable.attrs.get(attribute), (name, attribute)


def test_columns_beside_the_blocks(project, tmp_path):
    result = bn.load(project / "configs" / "quickstart.json", set=SETS).run(out=tmp_path / "out")
    ins, opened = result["ins"], bn.open(tmp_path / "out")["ins"]
    assert "position.local_north" in ins.others and any(name.endswith(".noise") for name in ins.others)
    assert list(ins.others) == list(opened.others)
    for name, series in ins.others.items():
        same(series, opened[name])
    north = ins["position.local_north"]
    assert north.units == "m" and abs(north[0]) < 10
    with open(tmp_path / "out" / "ins.csv", newline="") as file:
        assert [head.split("[")[0] for head in next(csv.reader(file))][1:] == list(ins.to_pandas().columns)


def test_a_study_that_is_opened_is_the_study(project, command, tmp_path, figures_of):
    command("study", "configs/transfer_alignment/table3.json", "--runs", "2", "--out", tmp_path, "--quiet")
    opened, here = bn.open(tmp_path), bn.load(project / "configs" / "transfer_alignment" / "table3.json").study(runs=2)
    assert isinstance(opened, bn.StudyResult) and (opened.runs, opened.seed) == (here.runs, here.seed)
    assert figures_of(dict(opened.summary)) == figures_of(dict(here.summary))
    assert all(np.array_equal(opened[v][m], here[v][m]) for v in here for m in here[v])
    assert opened.tables == here.tables and opened.config == here.config
    assert pickle.loads(pickle.dumps(here)).to_pandas().equals(here.to_pandas())


def test_a_folder_without_results_is_a_data_error(tmp_path):
    with pytest.raises(bn.DataError, match=str(tmp_path)):
        bn.open(tmp_path)
    (tmp_path / "run.nc").write_bytes(b"no netcdf")
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(bn.DataError, match="run.nc"):
        bn.open(tmp_path)


def test_without_records_there_are_figures_alone(project):
    result = bn.load(project / "configs" / "quickstart.json").run(records=False, innovations=False)
    assert len(result["ins"].t) == 0 and result["ins"]["position"].shape == (0, 3)
    assert result.summary["filters"]["ins"]["steps"] > 0


def test_missing_pandas_is_an_import_error_that_says_what_to_install(run, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(ImportError, match="python3-pandas"):
        run["ins"].to_pandas()
