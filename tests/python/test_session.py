# SPDX-License-Identifier: Apache-2.0
"""Sessions: the numbers of a run, refusals that change nothing, snapshots, threads, no leaks."""

import ctypes
import gc
import os
import resource
import signal
import threading

import binnacle as bn
import numpy as np
import pytest

CHANNELS = ("drive.initial", "drive.imu", "drive.gnss")  # in the order in which the simulator emits those of one instant


@pytest.fixture(scope="module")
def drive(project):
    return bn.load(project / "configs" / "quickstart.json")


@pytest.fixture(scope="module")
def recorded(drive):
    """A run, and the samples that its source gave."""
    return drive.run(seed=1, keep=CHANNELS)


def instants_of(channels):
    """[(t_ns, [(channel, t0, t, fields, covariance)])] in order of time."""
    by_time = {}
    for name, samples in channels.items():
        fields = np.stack(list(samples.values()), axis=1)
        for i, t in enumerate(samples.t_ns):
            t0 = None if np.isnan(samples.t0[i]) else np.timedelta64(round(samples.t0[i] * 1e9), "ns")
            P = None if samples.covariance is None or np.isnan(samples.covariance[i]).any() else samples.covariance[i]
            by_time.setdefault(t, []).append((name, t0, np.timedelta64(t, "ns"), fields[i], P))
    return sorted(by_time.items())


@pytest.fixture(scope="module")
def instants(recorded):
    return instants_of(recorded.channels)


def push_instant(session, samples):
    with session.instant(samples[0][2]) as instant:
        for name, t0, _, fields, P in samples:
            instant.push(name, t0, fields, covariance=P)


def everything(session):
    """All that can be read, as bytes."""
    return session.state().tobytes() + session.covariance().tobytes() + repr(session.time_ns()).encode()


def test_a_snapshot_is_that_of_the_c_library(project):
    """A composition of no Python is that of any program: snapshots pass between them."""
    c = ctypes.CDLL(os.environ["BINNACLE_C_LIBRARY"])
    path = str(project / "configs" / "quickstart.json").encode()
    composition, session, size = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_uint64()
    assert c.binnacle_load(path, None, ctypes.byref(composition)) == 0
    assert c.binnacle_open(composition, ctypes.c_uint64(1), 0, ctypes.byref(session)) == 0
    assert c.binnacle_snapshot_size(session, ctypes.byref(size)) == 0
    snapshot = ctypes.create_string_buffer(size.value)
    assert c.binnacle_snapshot(session, snapshot, size) == 0
    here = bn.load(project / "configs" / "quickstart.json").session(seed=1)
    assert here.snapshot() == snapshot.raw
    here.restore(snapshot.raw)
    assert c.binnacle_close(session) == 0 and c.binnacle_release(composition) == 0


def test_pushed_samples_give_what_the_run_gives_to_the_bit(drive, recorded, instants):
    s = drive.session(seed=1)
    ins, position, attitude = recorded["ins"], s.block("ins/position"), s.block("attitude")
    records = {t: i for i, t in enumerate(ins.t_ns)}
    compared = 0
    for t, samples in instants:
        push_instant(s, samples)
        i = records.get(s.time_ns()) if s.time_ns() == t else None
        if i is None:
            continue
        assert np.array_equal(position.read(), np.asarray(ins["position"])[i])
        assert np.array_equal(attitude.sigma(), ins["attitude"].sigma[i])
        compared += 1
    assert compared > 0.9 * len(ins.t_ns) > 500
    assert s.verdict() == recorded.verdict == "ok" and s.reasons() == [] and s.healthy() and s.diagnosis() == ""
    counts, figures = s.counts("fix"), recorded.summary["filters"]["ins"]["measurements"]["fix"]
    assert counts["accepted"] == figures["accepted"] > 100 and counts["nis_mean"] > 0
    assert s.filter_counts()["steps"] > 10_000
    assert s.channel("drive.imu").counts()["pushed"] == len(recorded.channels["drive.imu"].t)


def test_rows_are_pushed_as_a_run_has_them(project):
    """Ranges to several anchors, a row each, beside an IMU, a compass, a barometer and a velocity log."""
    composition = bn.load(project / "configs" / "aiding" / "ins.json")
    channels = [name for name in composition.channels if name.startswith("aiding.") and name != "aiding.truth"]
    run = composition.run(seed=1, keep=["drive.initial", "drive.imu", "drive.gnss", *channels])
    s, ranges = composition.session(seed=1), run.channels["aiding.range"]
    rows_of = np.stack([ranges[name] for name in s.channel("aiding.range").row_fields], axis=1)
    assert len(rows_of) > len(ranges.t) > 100
    by_time = {}
    for name, samples in run.channels.items():
        fields = [samples[field] for field in s.channel(name).fields]
        for i, t in enumerate(samples.t_ns):
            rows = rows_of[ranges.sample == i] if name == "aiding.range" else None
            P = None if samples.covariance is None else samples.covariance[i]
            t0 = None if np.isnan(samples.t0[i]) else samples.t0[i]
            by_time.setdefault(t, []).append((name, t0, [numbers[i] for numbers in fields], rows, P))
    records, compared = {t: i for i, t in enumerate(run["ins"].t_ns)}, 0
    for t in sorted(by_time)[:6000]:
        with s.instant(np.timedelta64(t, "ns")) as instant:
            for name, t0, fields, rows, P in by_time[t]:
                instant.push(name, t0, fields or None, rows=rows, covariance=P)
        if t in records and s.time_ns() == t:
            assert np.array_equal(s.read("position"), np.asarray(run["ins"]["position"])[records[t]])
            compared += 1
    assert compared > 50 and s.counts("uwb")["accepted"] > 50
    before = s.snapshot()
    for wrong in (np.zeros((1, 3)), np.zeros(2), np.zeros((1000, 2))):
        with pytest.raises(ValueError, match="channel 'aiding.range' takes up to .* rows of 2 fields"):
            s.push("aiding.range", None, 1e4, None, rows=wrong)
    with pytest.raises(ValueError, match="has rows, which push\\(\\) takes, sample by sample"):
        s.push_many("aiding.range", None, [1e4], np.zeros((1, 2)))
    assert s.snapshot() == before


def test_another_number_gives_other_bits(drive, instants):
    """That the comparison above can fail."""
    sessions = [drive.session(), drive.session()]
    for _, samples in instants[:50]:
        for s in sessions:
            push_instant(s, samples)
    name, t0, t, fields, P = instants[50][1][0]
    sessions[0].push(name, t0, t, fields, covariance=P)
    sessions[1].push(name, t0, t, fields * (1 + 1e-9), covariance=P)
    assert everything(sessions[0]) != everything(sessions[1])


def imu_of(recorded, count=2000):
    imu = recorded.channels["drive.imu"]
    return imu.t0[:count], imu.t[:count], np.stack(list(imu.values()), axis=1)[:count]


def started(drive, instants):
    s = drive.session()
    push_instant(s, instants[0][1])
    assert s.started() and s.time() is not None
    return s


def test_many_at_once_are_those_one_by_one(drive, recorded, instants):
    t0s, ts, fields = imu_of(recorded)
    one, by_name, many, exact, by_list, strided = (started(drive, instants) for _ in range(6))
    imu = one.channel("drive.imu")
    for t0, t, row in zip(t0s, ts, fields):
        imu.push(t0, t, row)
        by_name.push("drive.imu", t0, t, list(row))
    many.push_many("drive.imu", t0s, ts, fields)
    t0s_ns, ts_ns = (np.round(times * 1e9).astype("m8[ns]") for times in (t0s, ts))
    exact.push_many(exact.channel("drive.imu"), t0s_ns, ts_ns, fields)
    by_list.push_many("drive.imu", list(t0s), list(ts), fields.tolist())
    strided.push_many("drive.imu", t0s, ts, np.repeat(fields, 2, axis=1)[:, ::2])
    expected = everything(one)
    assert one.healthy() and one.time() == pytest.approx(ts[-1]) and one.filter_counts()["steps"] == len(ts)
    for s in (by_name, many, exact, by_list, strided):
        assert everything(s) == expected


@pytest.mark.parametrize("dtype", [np.float32, np.int64])
def test_other_types_of_numbers_are_converted(drive, instants, dtype):
    sessions = started(drive, instants), started(drive, instants)
    fields = np.array([0, 0, 0, 1, 0, -1]).astype(dtype)
    sessions[0].push("drive.imu", 0, 0.01, fields)
    sessions[1].push("drive.imu", np.float64(0), np.timedelta64(10, "ms"), fields.astype(float))
    assert everything(sessions[0]) == everything(sessions[1]) and sessions[0].healthy() and sessions[0].time() == 0.01


def test_a_snapshot_goes_on_bit_for_bit(drive, instants):
    s, other = drive.session(), drive.session(seed=9)
    for _, samples in instants[:1500]:
        push_instant(s, samples)
    snapshot, here = s.snapshot(), everything(s)
    for _, samples in instants[1500:3000]:
        push_instant(s, samples)
    expected = everything(s)
    assert expected != here
    for back in (s, other):
        back.restore(snapshot)
        assert everything(back) == here
        for _, samples in instants[1500:3000]:
            push_instant(back, samples)
        assert everything(back) == expected and back.snapshot() == s.snapshot()
    s.reset()
    assert not s.started() and s.time() is None


def test_a_snapshot_of_another_composition_is_refused(project, drive):
    other = bn.load(project / "configs" / "quickstart.json", set={"/filters/ins/measurements/fix/gate": 0.99}).session()
    s = drive.session()
    for wrong in (other.snapshot(), b"", s.snapshot()[:-8], b"x" * 100):
        with pytest.raises(bn.ConfigError, match="the snapshot cannot be restored"):
            s.restore(wrong)


ZEROS = np.zeros(6)


@pytest.mark.parametrize(
    "call, error, message",
    [
        (
            lambda s: s.push("drive.imuu", 0, 0.01, ZEROS),
            KeyError,
            "there is no channel 'drive.imuu'; did you mean 'drive.imu'?",
        ),
        (lambda s: s.channel("imu"), KeyError, "there is no channel 'imu'"),
        (lambda s: s.block("ins/positon"), KeyError, "did you mean 'ins/position'?"),
        (lambda s: s.read("positon"), KeyError, "did you mean 'position'?"),
        (lambda s: s.counts("fixx"), KeyError, "did you mean 'fix'?"),
        (lambda s: s.time("inss"), KeyError, "did you mean 'ins'?"),
        (
            lambda s: s.push("drive.imu", 0, 0.01, ZEROS[:5]),
            ValueError,
            r"has 6 fields \(wx, wy, wz, fx, fy, fz\); got an array of shape \(5,\)",
        ),
        (lambda s: s.push("drive.imu", 0, 0.01, [ZEROS]), ValueError, r"got an array of shape \(1, 6\)"),
        (lambda s: s.push("drive.imu", 0, 0.01, None), TypeError, "has 6 fields .*; got None"),
        (lambda s: s.push("drive.imu", 0, 0.01, ["1"] * 6), TypeError, "expected an array of real numbers"),
        (
            lambda s: s.push("drive.imu", 0, 0.01, np.ma.masked_array(ZEROS, [1, 0, 0, 0, 0, 0])),
            ValueError,
            r"fields is a masked array, 1 masked: say what these are with .filled\(numpy.nan\)",
        ),
        (
            lambda s: s.push_many("drive.imu", None, np.ma.masked_equal([1.0, 2], 2), np.zeros((2, 6))),
            ValueError,
            "ts is a masked array",
        ),
        (lambda s: s.push("drive.imu", 0, 0.01, ZEROS + 1j), TypeError, "complex128.*expected an array of real numbers"),
        (
            lambda s: s.push("drive.imu", 0.01, 0.01, ZEROS),
            ValueError,
            "begins at t0 = 10000000 ns and ends at t = 10000000 ns",
        ),
        (lambda s: s.push("drive.imu", 0, float("nan"), ZEROS), ValueError, "t is nan s: times are finite"),
        (lambda s: s.push("drive.imu", 0, np.timedelta64("NaT"), ZEROS), ValueError, "t is NaT"),
        (lambda s: s.push("drive.imu", 0, 1e12, ZEROS), ValueError, "within 146 years"),
        (lambda s: s.push("drive.imu", 0, np.timedelta64(2**62 + 1, "ns"), ZEROS), ValueError, "within 146 years"),
        (lambda s: s.push("drive.imu", 0, "0.01", ZEROS), TypeError, "t is of type 'str'"),
        (lambda s: s.push("drive.imu", 0, None, ZEROS), TypeError, "t is None"),
        (
            lambda s: s.push("drive.imu", 0, 0.01, ZEROS, rows=[[1.0]]),
            ValueError,
            "takes up to 0 rows of 0 fields; got an array of shape",
        ),
        (lambda s: s.push("drive.imu", 0, 0.01, ZEROS, covariance=np.eye(2)), ValueError, "takes no covariance"),
        (lambda s: s.push("drive.imu", 0, 0.01), TypeError, "lacks the argument 'fields'"),
        (lambda s: s.push("drive.imu", 0, 0.01, ZEROS, covarianc=1), TypeError, "has no argument 'covarianc'"),
        (lambda s: s.push("drive.imu", 0, 0.01, ZEROS, t=1), TypeError, "got 't' twice"),
        (lambda s: s.push(3, 0, 0.01, ZEROS), TypeError, "a channel's name is a str, not int"),
        (
            lambda s: s.push_many("drive.imu", [0, 1], [1, 2], np.zeros((2, 5))),
            ValueError,
            r"arrays has the shape \(2, 6\); got \(2, 5\)",
        ),
        (lambda s: s.push_many("drive.imu", [0], [1, 2], np.zeros((2, 6))), ValueError, "t0s has 1 times, ts has 2"),
        (
            lambda s: s.push_many("drive.imu", [0, 2], [1, 2], np.zeros((2, 6))),
            ValueError,
            r"t0s\[1\] = 2000000000 ns is not before ts\[1\]",
        ),
        (lambda s: s.push_many("drive.imu", [0, 1], [1, np.inf], np.zeros((2, 6))), ValueError, r"ts\[1\] is inf s"),
        (
            lambda s: s.push_many("drive.imu", None, [[1, 2]], np.zeros((2, 6))),
            ValueError,
            r"ts has the shape \(1, 2\); expected \(n,\)",
        ),
        (lambda s: s.read("position", out=np.zeros(2)), ValueError, r"out has the shape \(2,\) .*expected \(3,\)"),
        (lambda s: s.read("position", out=np.zeros(3, np.float32)), ValueError, "expected"),
        (lambda s: s.read("position", out=[0, 0, 0]), TypeError, "out is not a writable array"),
        (lambda s: s.commit(np.timedelta64("NaT")), ValueError, "t is NaT"),
        (lambda s: s.commit("now"), TypeError, "a time is a number of seconds"),
        (lambda s: s.reset(run=-1), ValueError, "run is -1: expected a whole number from 0"),
    ],
)
def test_what_is_wrong_is_refused_and_changes_nothing(drive, recorded, instants, call, error, message):
    s = started(drive, instants)
    before = s.snapshot(), s.channel("drive.imu").counts()
    with pytest.raises(error, match=message):
        call(s)
    assert (s.snapshot(), s.channel("drive.imu").counts()) == before


def test_what_a_session_is_made_with_is_checked(drive):
    with pytest.raises(ValueError, match="estimates is 'late'; expected 'live' or 'settled'"):
        drive.session(estimates="late")
    with pytest.raises(ValueError, match="run is -1: expected a whole number from 0"):
        drive.session(run=-1)


def test_readers(drive, instants):
    s = started(drive, instants)
    position = s.block("ins/position")
    out = np.zeros(3)
    assert position.read(out) is out and np.array_equal(out, s.read("position")) and out[2] != 0
    assert s.sigma("position", out) is out and np.array_equal(out, position.sigma())
    assert (position.name, position.outputs, position.units) == ("position", ["lat", "lon", "height"], ["rad", "rad", "m"])
    P, rows = s.covariance("ins"), s.rows()
    assert P.shape == (15, 15) and np.array_equal(P, P.T) and len(rows) == 15
    at = [i for i, row in enumerate(rows) if row.startswith("velocity.")]
    assert np.array_equal(s.covariance("velocity"), P[np.ix_(at, at)])
    assert np.array_equal(s.covariance("ins/velocity"), s.block("velocity").covariance())
    assert np.array_equal(s.covariance(), P)
    imu = s.channel("drive.imu")
    assert imu.fields == ["wx", "wy", "wz", "fx", "fy", "fz"] and imu.units["fx"] == "m/s" and imu.row_fields == []
    assert s.filters == ["ins"] and s.start_time() == s.time() and s.notes() == []


def test_an_input_of_nothing_but_nan_is_no_input(drive, instants):
    """After the start, which it says, as a cable that came loose would give it."""
    s = started(drive, instants)
    imu = s.channel("drive.imu")
    t = s.time() + 0.01 * np.arange(3600)
    s.push_many(imu, t, t + 0.01, np.full((3600, 6), np.nan))
    assert s.filter_counts()["input_gaps"] == 3600
    assert s.verdict() == "lost"
    (reason,) = [reason for reason in s.reasons() if reason.code == "B118"]
    assert "ended at" in reason.message and "before the newest sample" in reason.message


def test_before_the_start_there_is_no_estimate(drive, instants):
    s = drive.session()
    assert not s.started() and s.time() is None and s.verdict() == "ok"
    assert np.isnan(s.read("position")).all() and np.isnan(s.sigma("position")).all()
    assert np.isfinite(started(drive, instants).read("position")).all()


def test_a_broken_filter_says_so_and_takes_no_more(drive, instants):
    s = started(drive, instants)
    s.push("drive.imu", 0, 0.01, [1e300] * 6)
    s.push("drive.imu", 0.01, 0.02, [1e300] * 6)
    assert not s.healthy() and s.diagnosis() and s.verdict() == "lost"
    before = s.state()
    s.push("drive.imu", 0.02, 0.03, ZEROS)
    assert np.array_equal(s.state(), before, equal_nan=True)


def test_a_second_thread_is_refused_while_one_is_in_the_session(drive, recorded, instants):
    s = started(drive, instants)
    imu = recorded.channels["drive.imu"]
    fields = np.stack(list(imu.values()), axis=1)
    refusals, done = [], threading.Event()

    def push_all():
        s.push_many("drive.imu", imu.t0, imu.t, fields)
        done.set()

    thread = threading.Thread(target=push_all)
    thread.start()
    while not done.is_set():
        try:
            s.read("position")
        except RuntimeError as error:
            refusals.append(str(error))
    thread.join()
    assert refusals and all("one thread at a time" in text for text in refusals)
    alone = started(drive, instants)
    alone.push_many("drive.imu", imu.t0, imu.t, fields)
    assert everything(alone) == everything(s) and s.healthy() and s.time() == pytest.approx(imu.t[-1])


def test_threads_each_with_a_session_give_what_one_gives(drive, recorded, instants):
    t0s, ts, fields = imu_of(recorded, 10_000)
    alone = started(drive, instants)
    alone.push_many("drive.imu", t0s, ts, fields)
    assert alone.healthy() and alone.time() == pytest.approx(ts[-1])
    sessions = [started(drive, instants) for _ in range(8)]
    threads = [threading.Thread(target=s.push_many, args=("drive.imu", t0s, ts, fields)) for s in sessions]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {everything(s) for s in sessions} == {everything(alone)}


def rss_mb():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize() / 1e6


def test_ten_thousand_sessions_do_not_leak(drive, instants):
    def open_some(count):
        for _ in range(count):
            s = started(drive, instants)
            s.channel("drive.imu").push(0, 0.01, ZEROS)
            s.block("position").read()
            s.snapshot()

    open_some(1000)
    gc.collect()
    before = rss_mb()
    open_some(10_000)
    gc.collect()
    assert rss_mb() - before < 8  # of 10^4 sessions, each with an arena of some 100 kB


def test_handles_keep_their_session(drive, instants):
    s = started(drive, instants)
    imu, position = s.channel("drive.imu"), s.block("position")
    before = position.read()
    del s
    gc.collect()
    imu.push(0, 0.01, [0, 0, 0, 0.01, 0, -0.09])
    assert not np.array_equal(position.read(), before)


def test_ctrl_c_stops_many_samples_between_two_of_them(drive, recorded, instants):
    imu = recorded.channels["drive.imu"]
    count = 3_000_000
    ns = np.arange(count + 1, dtype="m8[ns]") * 10_000_000
    fields = np.resize(np.stack(list(imu.values()), axis=1), (count, 6))
    s = started(drive, instants)
    with pytest.raises(KeyboardInterrupt):
        threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
        s.push_many("drive.imu", ns[:-1], ns[1:], fields)
    done = s.channel("drive.imu").counts()["pushed"]
    assert 0 < done < count and s.healthy() and s.time_ns() == done * 10_000_000
    s.push("drive.imu", ns[done], ns[done + 1], fields[done])
    assert s.time_ns() == (done + 1) * 10_000_000
