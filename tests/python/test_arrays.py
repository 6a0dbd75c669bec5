# SPDX-License-Identifier: Apache-2.0
"""Arrays as sources: the bits of the same numbers in files. Samples of channels as arrays."""

import json

import binnacle as bn
import numpy as np
import pytest

TUTORIAL = ("raw_imu", "gnss", "truth")


def columns_of(path):
    with open(path) as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",", unpack=True)))


@pytest.fixture(scope="module")
def folder(project):
    return project / "configs" / "tutorial"


@pytest.fixture(scope="module")
def from_files(folder):
    return bn.load(folder / "drive.json", vars={"data": folder})


@pytest.fixture(scope="module")
def data(folder):
    """The numbers of the tutorial's files, as a notebook would have them."""
    imu, gnss, truth = (columns_of(folder / name) for name in ("imu.csv", "gnss.csv", "truth.csv"))
    of_imu = {"wx": ("deg/s", "gx_dps"), "wy": ("deg/s", "gy_dps"), "wz": ("deg/s", "gz_dps"),
              "fx": ("g", "ax_g"), "fy": ("g", "ay_g"), "fz": ("g", "az_g")}
    of_fix = {"lat": ("deg", "lat_deg"), "lon": ("deg", "lon_deg"), "height": ("m", "height_m"),
              "vn": ("m/s", "vn_mps"), "ve": ("m/s", "ve_mps"), "vd": ("m/s", "vd_mps")}
    of_truth = {**of_fix, **{name: ("deg", f"{name}_deg") for name in ("roll", "pitch", "yaw")}}
    fields = lambda columns, of: {name: (unit, columns[column]) for name, (unit, column) in of.items()}  # noqa: E731
    return {"raw_imu": bn.Arrays(imu["gps_s"], fields(imu, of_imu), max_gap=0.05),
            "gnss": (gnss["utc_s"] + 18, fields(gnss, of_fix)),
            "truth": (truth["gps_s"], fields(truth, of_truth))}


def same_bits(one, other):
    assert list(one) == list(other)
    for name, filter in one.items():
        assert np.array_equal(filter.t_ns, other[name].t_ns) and len(filter.t) > 0
        for block, series in filter.items():
            assert series.tobytes() == other[name][block].tobytes()
            assert series.sigma.tobytes() == other[name][block].sigma.tobytes()
        for error, series in filter.errors.items():
            assert series.tobytes() == other[name].errors[error].tobytes()
        for measurement, innovations in filter.innovations.items():
            assert innovations.residual.tobytes() == other[name].innovations[measurement].residual.tobytes()


def test_arrays_in_place_of_files_give_the_same_bits(folder, from_files, data, figures_of):
    from_arrays = bn.load(folder / "drive.json", vars={"data": folder}, data=data)
    one, other = from_files.run(), from_arrays.run()
    same_bits(one, other)
    assert len(one["ins"]["position"]) > 500
    assert figures_of(dict(one.summary))["filters"] == figures_of(dict(other.summary))["filters"]


def test_no_file_is_needed(tmp_path, folder, from_files, data):
    config = from_files.config
    del config["sources"]
    made = bn.parse(config, name=tmp_path / "notebook.json", data=data)
    same_bits(from_files.run(), made.run())


def test_a_config_may_say_what_its_arrays_are(tmp_path, from_files, folder, data):
    config = from_files.config
    columns = config["sources"]["raw_imu"]["columns"]
    columns = {name: {"unit": column["unit"], "kind": "rate"} for name, column in columns.items()}
    config["sources"]["raw_imu"] = {"type": "numpy/arrays", "max_gap": "50 ms", "columns": columns}
    bare = bn.Arrays(data["raw_imu"].t, {name: array for name, (_, array) in data["raw_imu"].fields.items()})
    same_bits(from_files.run(), bn.parse(config, name=folder / "mine.json", data={**data, "raw_imu": bare}).run())
    with pytest.raises(bn.ConfigError, match="no arrays were given for this source; .*data={'raw_imu'"):
        bn.parse(config, name=folder / "mine.json")


def test_numbers_are_in_si_where_no_unit_is_given(folder, from_files, data):
    imu = data["raw_imu"]
    to_si = {"deg/s": np.pi / 180, "g": 9.80665}
    si = {name: array * to_si[unit] for name, (unit, array) in imu.fields.items()}
    run = bn.load(folder / "drive.json", vars={"data": folder}, data={"raw_imu": bn.Arrays(imu.t, si, max_gap=0.05)}).run()
    np.testing.assert_allclose(run["ins"]["position"], from_files.run()["ins"]["position"], rtol=1e-12)


@pytest.mark.parametrize("way", ["t0", "interval", "increment", "timedelta"])
def test_intervals(folder, from_files, data, way):
    """Begins of intervals, a fixed length, increments and exact times come to the same as intervals from time to time."""
    imu = data["raw_imu"]
    ns = np.round(imu.t * 1e9).astype("m8[ns]")
    t0 = np.concatenate([[np.timedelta64("NaT", "ns")], ns[:-1]])
    if way == "t0":
        given = (t0, ns, imu.fields)
    elif way == "interval":
        given = bn.Arrays(imu.t, imu.fields, interval=0.01, max_gap=0.05)
    elif way == "timedelta":
        given = bn.Arrays(ns, imu.fields, max_gap=np.timedelta64(50, "ms"))
    else:
        integral = {"deg/s": "deg", "g": "g*s"}
        per_interval = {name: (integral[unit], array * 0.01) for name, (unit, array) in imu.fields.items()}
        given = bn.Arrays(imu.t, per_interval, kind="increment", max_gap=0.05)
    run = bn.load(folder / "drive.json", vars={"data": folder}, data={"raw_imu": given}).run()
    if way in ("t0", "timedelta"):
        same_bits(from_files.run(), run)
    else:  # the first sample has an interval then; an increment is rounded
        np.testing.assert_allclose(run["ins"]["position"][-1], from_files.run()["ins"]["position"][-1], rtol=1e-7)


def test_gaps_are_reported_as_of_files(folder, data):
    imu = data["raw_imu"]
    keep = np.ones(len(imu.t), bool)
    keep[5000:5100] = False
    cut = bn.Arrays(imu.t[keep], {name: (unit, array[keep]) for name, (unit, array) in imu.fields.items()}, max_gap=0.05)
    run = bn.load(folder / "drive.json", vars={"data": folder}, data={"raw_imu": cut}).run()
    gaps = [warning for warning in run.warnings if warning.code == "B065"]
    assert len(gaps) == 1 and "1 gap longer than 0.05 s: 1.01 s from 1050 s to 1051.01 s" in gaps[0].message


def test_the_hash_is_of_the_numbers_and_not_of_where_they_lie(folder, data):
    load = lambda data: bn.load(folder / "drive.json", vars={"data": folder}, data=data)  # noqa: E731
    one, same = load(data), load({**data, "gnss": (data["gnss"][0].copy(), data["gnss"][1])})
    snapshot = one.session().snapshot()
    same.session().restore(snapshot)
    fields = dict(data["gnss"][1])
    fields["lat"] = ("deg", np.nextafter(fields["lat"][1], 90))
    with pytest.raises(bn.ConfigError, match="another composition"):
        load({**data, "gnss": (data["gnss"][0], fields)}).session().restore(snapshot)


def test_later_changes_of_an_array_change_nothing(folder, from_files, data):
    t, fields = data["gnss"][0].copy(), {name: (unit, array.copy()) for name, (unit, array) in data["gnss"][1].items()}
    made = bn.load(folder / "drive.json", vars={"data": folder}, data={"gnss": (t, fields)})
    t += 1e3
    for _, array in fields.values():
        array[:] = np.nan
    same_bits(from_files.run(), made.run())


T = np.arange(5.0)
FIX = {name: np.zeros(5) for name in ("lat", "lon", "height", "vn", "ve", "vd")}


@pytest.mark.parametrize(
    "given, error, message",
    [
        ((T[:4], FIX), ValueError, r"data\['gnss'\]: field 'lat' has the shape \(5,\); with 4 times expected \(4,\)"),
        ((T, {**FIX, "vn": np.zeros((5, 1))}), ValueError, r"field 'vn' has the shape \(5, 1\)"),
        ((T, {"lat": FIX["lat"], "lon": FIX["lon"]}), ValueError, "lacks the field 'height', which the config's source has"),
        ((T, {**FIX, "vn": ["a"] * 5}), TypeError, "field 'vn' has the type <U1; expected real numbers"),
        ((T, {}), ValueError, "has no field"),
        ((T, FIX["lat"]), TypeError, r"fields is a ndarray; expected \{name: array\}"),
        (T, TypeError, "is a ndarray: expected"),
        ((np.where(T == 2, np.nan, T), FIX), ValueError, r"data\['gnss'\]: t\[2\] is nan s: times are finite"),
        ((T.astype(str), FIX), TypeError, "t has the type"),
        ((T[:, None], FIX), ValueError, r"t has the shape \(5, 1\); expected \(n,\)"),
        (bn.Arrays(T, FIX, kind="speed"), ValueError, "kind of 'lat' is 'speed'; expected one of 'level', 'rate'"),
        (bn.Arrays(T, FIX, units={"latt": "deg"}), ValueError, "units names 'latt', which is no field"),
        (bn.Arrays(T, {**FIX, "vn": ("m/s", T)}, units={"vn": "m/s"}), ValueError, "has a unit in units and in its pair"),
        ((T, {**FIX, "mine": np.zeros(5)}), ValueError, "field 'mine' needs a unit"),
        ((T[:4], T, FIX), ValueError, "t0 has 4 times, t has 5"),
        ((T[::-1], FIX), bn.DataError, r"data\['gnss'\].*B063.*time does not increase: 3 s at index 1 after 4 s"),
        ((np.minimum(T, 3), FIX), bn.DataError, "time does not increase: 3 s at index 4 after 3 s"),
        ((T[:0], {name: array[:0] for name, array in FIX.items()}), bn.DataError, "there are no samples"),
        ((T, {**FIX, "ve": np.where(T == 3, np.nan, 0)}), bn.DataError, r"B064.*'ve' is nan at index 3 \(t = 3 s\).*missing="),
        ((T, {**FIX, "ve": np.where(T == 3, -np.inf, 0)}), bn.DataError, "field 've' is -inf at index 3"),
        (bn.Arrays(T, {**FIX, "ve": np.where(T == 3, np.inf, 0)}, missing=[np.nan]), bn.DataError, "field 've' is inf"),
        (bn.Arrays(T, FIX, t0=T, kind={"vn": "rate"}), bn.DataError, "t0 is not before t at index 0"),
        ((T, {**FIX, "lat": ("degrees", FIX["lat"])}), bn.ConfigError, "unknown unit 'degrees'"),
        ((T, {**FIX, "lat": ("m", FIX["lat"])}), bn.ConfigError, "lat"),
        (bn.Arrays(T, FIX, interval=1.0, kind="level"), bn.ConfigError, "an interval needs a field of kind"),
    ],
)
def test_what_is_wrong_with_arrays_is_refused_by_name(folder, given, error, message):
    with pytest.raises(error, match=message):
        bn.load(folder / "drive.json", vars={"data": folder}, data={"gnss": given})


def test_a_name_that_nothing_takes_is_refused(folder, data):
    with pytest.raises(ValueError, match=r"data\['gnns'\]: the config has no such source.*did you mean 'gnss'\?"):
        bn.load(folder / "drive.json", vars={"data": folder}, data={"gnns": data["gnss"]})


WALK = {"binnacle": 1,
        "filters": {"f": {"blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "sigma": 1}},
                          "process": {"walk": {"type": "random_walk", "blocks": {"x": "x"}, "q": "1 m/sqrt(s)"}},
                          "measurements": {"z": {"channel": "z", "type": "linear_measurement", "blocks": {"x": "x"},
                                                 "fields": {"z0": "z"}, "sigma": [1]}}}}}


def test_a_misspelt_type_is_near_that_of_arrays(folder):
    with pytest.raises(bn.ConfigError, match="did you mean '(numpy/)?arrays'"):
        bn.load(folder / "drive.json", vars={"data": folder}, set={"/sources/raw_imu/type": "array"})


def test_what_is_masked_is_missing_and_a_masked_time_is_refused():
    z = np.ma.masked_array([100, 150, -9999, 200], [False, True, True, False])
    run = bn.parse(WALK, data={"z": bn.Arrays([1, 2, 3, 4], {"z": ("cm", z)})}).run(keep="z")
    np.testing.assert_array_equal(run.channels["z"]["z"], [1, np.nan, np.nan, 2])
    t = np.ma.masked_equal([1.0, 2, 3, 4], 3)
    with pytest.raises(ValueError, match=r"t is a masked array, 1 masked: .*filled\(numpy.nan\)"):
        bn.parse(WALK, data={"z": bn.Arrays(t, {"z": ("cm", z)})})
    nothing_masked = np.ma.masked_array([1.0, 2, 3, 4])
    same_bits(bn.parse(WALK, data={"z": bn.Arrays(nothing_masked, {"z": ("cm", z)})}).run(), run)


def test_missing_numbers_are_no_data(tmp_path):
    """As in csv: NaN and stated numbers become "no data", which a measurement cannot use."""
    config = WALK
    kept = bn.Arrays([1, 2, 3, 4], {"z": ("cm", [100, np.nan, -9999, 200])}, missing=[np.nan, -9999])
    path = tmp_path / "z.csv"
    path.write_text("t,z\n1,100\n2,nan\n3,-9999\n4,200\n")
    csv = {"type": "csv", "path": str(path), "columns": {"z": {"unit": "cm", "missing": ["nan", "-9999"]}}}
    runs = []
    for sources, data in (({"z": csv}, None), ({}, {"z": kept}), ({"z": csv}, {"z": (kept.t, kept.fields)})):
        runs.append(bn.parse({**config, "sources": sources}, data=data).run(keep="z"))
    for run in runs:
        z = run.channels["z"]
        assert z.t_ns.tolist() == [10**9, 2 * 10**9, 3 * 10**9, 4 * 10**9] and np.isnan(z.t0).all()
        np.testing.assert_array_equal(z["z"], runs[0].channels["z"]["z"])
        np.testing.assert_array_equal(np.isnan(z["z"]), [False, True, True, False])
    same_bits(runs[0], runs[1])
    same_bits(runs[0], runs[2])


def test_rows_of_one_time_are_one_sample(tmp_path):
    t = [1, 1, 2, 2, 2, 3]
    fields = {"satellite": ("1", [3, 5, 3, 5, 7, 9]), "pseudorange": ("km", [1.0, 2, 3, 4, 5, 6])}
    path = tmp_path / "ranges.csv"
    lines = zip(t, fields["satellite"][1], fields["pseudorange"][1])
    path.write_text("t,satellite,pseudorange\n" + "".join(f"{a},{b},{c}\n" for a, b, c in lines))
    source = {"type": "csv", "path": str(path), "rows": {"key": "satellite", "max_rows": 4},
              "columns": {"satellite": {"unit": "1"}, "pseudorange": {"unit": "km"}}}
    z = {"z": ([1.0, 2], {"z": ("m", [0.0, 0])})}
    config = {**WALK, "sources": {"ranges": source}}
    from_file = bn.parse(config, data=z).run(keep="ranges").channels["ranges"]
    arrays = bn.parse(config, data={"ranges": (t, fields), **z}).run(keep="ranges").channels["ranges"]
    for kept in (from_file, arrays):
        assert kept.t.tolist() == [1, 2, 3] and kept.rows.tolist() == [2, 3, 1] and kept.sample.tolist() == [0, 0, 1, 1, 1, 2]
        assert kept["pseudorange"].tolist() == [1000, 2000, 3000, 4000, 5000, 6000] and kept.units["pseudorange"] == "m"
    by_name = bn.Arrays(t, fields, rows="satellite")
    sinks = {"ranges": {"type": "json_writer", "input": "ranges", "to": f"file:{tmp_path}/ranges.jsonl"}}
    named = bn.parse({**WALK, "sinks": sinks}, data={"ranges": by_name, **z}).run(keep="ranges")
    assert named.channels["ranges"].rows.tolist() == [2, 3, 1]
    with pytest.raises(bn.DataError, match="the same number twice at 1 s, at the indices 0 and 1"):
        bn.parse(config, data={"ranges": (t, {**fields, "satellite": ("1", [3] * 6)}), **z})
    with pytest.raises(bn.DataError, match="more than 2 rows at 2 s"):
        bn.parse(config, data={"ranges": bn.Arrays(t, fields, rows={"key": "satellite", "max_rows": 2}), **z})


def test_times_decades_apart(tmp_path):
    years = 365.25 * 86400
    z = {"z": ([1.0, 2], {"z": ("m", [0.0, 0])})}
    rates = lambda t: bn.Arrays(t, {"w": ("rad/s", np.zeros(len(t)))}, kind="rate")  # noqa: E731
    config = {**WALK, "sinks": {"far": {"type": "json_writer", "input": "far", "to": f"file:{tmp_path}/far.jsonl"}}}
    run = bn.parse(config, data={"far": rates([0.0, 29.3 * years, 58.6 * years, 87.9 * years]), **z}).run(keep="far")
    assert len(run.channels["far"].t) == 4
    assert not [warning for warning in run.warnings if warning.code == "B065"]  # ten times the usual step is no negative one
    with pytest.raises(ValueError, match="within 146 years of 0"):
        bn.parse(config, data={"far": rates([-200 * years, 0.0, 200 * years]), **z}).run()


def test_channels_are_kept_and_the_figures_stay(project, figures_of):
    composition = bn.load(project / "configs" / "quickstart.json")
    plain, kept = composition.run(seed=2), composition.run(seed=2, keep=["drive.imu", "drive.gnss"])
    same_bits(plain, kept)
    assert figures_of(dict(plain.summary)) == figures_of(dict(kept.summary))
    assert plain.channels == {} and list(kept.channels) == ["drive.imu", "drive.gnss"]
    imu, gnss = kept.channels["drive.imu"], kept.channels["drive.gnss"]
    assert list(imu) == ["wx", "wy", "wz", "fx", "fy", "fz"] and len(imu["wx"]) == len(imu.t)
    assert imu.units["wx"] == "rad" and imu.kinds["wx"] == "increment"
    np.testing.assert_allclose(imu.t[1:] - imu.t0[1:], 0.01, atol=1e-9)
    assert np.isnan(gnss.t0).all() and np.isfinite(gnss["lat"]).all()
    again = composition.run(seed=2, keep="drive.imu").channels["drive.imu"]
    assert again["fz"].tobytes() == imu["fz"].tobytes()
    assert composition.run(seed=3, keep="drive.imu").channels["drive.imu"]["fz"].tobytes() != imu["fz"].tobytes()
    assert imu["fz"].tobytes() == again["fz"].tobytes()  # a later run leaves what was kept alone
    with pytest.raises(KeyError, match="there is no channel 'drive.imuu'; did you mean 'drive.imu'?"):
        composition.run(keep=["drive.imuu"])


def test_the_config_shows_what_was_given(folder, data):
    config = bn.load(folder / "drive.json", vars={"data": folder}, data=data).config
    assert config["sources"]["raw_imu"]["type"] == "numpy/arrays" and len(config["sources"]["raw_imu"]["content"]) == 32
    assert json.dumps(config)
