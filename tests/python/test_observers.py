# SPDX-License-Identifier: Apache-2.0
"""Observers in Python, and the step log."""

import binnacle as bn
import numpy as np
import pytest


@pytest.fixture(scope="module")
def quickstart(project):
    return bn.load(project / "configs" / "quickstart.json")


@pytest.fixture(scope="module")
def logged(quickstart):
    return quickstart.run(seed=3, log=True)


def test_the_log_is_the_covariance_recursion(logged):
    """P of the start, carried on by Phi, Qd, H, K, R and resets as the records say, is every P that the filter had."""
    log, P = logged["ins"].log, None
    counts = dict.fromkeys(("start", "step", "update"), 0)
    worst = 0.0
    for kind in log.kinds:
        i = counts[kind]
        counts[kind] += 1
        if kind == "start":
            P = log.starts["P"][i]
        elif kind == "step":
            assert np.allclose(log.P0[i], P, rtol=1e-6, atol=1e-12)
            P = log.Phi[i] @ log.P0[i] @ log.Phi[i].T + log.Qd[i]
            worst = max(worst, np.max(np.abs(P - log.P1[i]) / np.sqrt(np.outer(np.diag(P), np.diag(P)))))
            P = log.P1[i]
        else:
            update = log.updates[i]
            if update.outcome != "accepted":
                continue
            n = len(P)
            J = np.eye(n) - update.K @ update.H
            P = J @ update.P0 @ J.T + update.K @ update.R @ update.K.T
            assert np.allclose(update.S, update.H @ update.P0 @ update.H.T + update.R, rtol=1e-9)
            assert np.allclose(update.delta, update.K @ update.residual, rtol=1e-9, atol=1e-15)
            P = P if update.reset is None else update.reset @ P @ update.reset.T
            worst = max(worst, np.max(np.abs(P - update.P1) / np.sqrt(np.outer(np.diag(P), np.diag(P)))))
            P = update.P1
    assert counts["step"] > 1000 and counts["update"] > 100
    assert worst < 1e-9


def test_the_log_has_all_samples_of_the_innovations(logged):
    updates, fix = logged["ins"].log.updates, logged["ins"].innovations["fix"]
    assert np.array_equal(updates.t, fix.t) and np.array_equal(updates.rows, fix.rows)
    assert np.array_equal(updates.nis, fix.nis, equal_nan=True) and np.array_equal(updates.outcome, fix.outcome)
    assert np.array_equal(np.concatenate([u.residual for u in updates if u.residual is not None]), fix.residual)


def test_what_is_not_wanted_is_not_there(quickstart):
    log = quickstart.run(log={"ins": ["transition"]})["ins"].log
    assert log.Phi.shape[1:] == (15, 15) and log.P0 is None and log.P1 is None
    assert log.updates[3].H is None and log.updates[3].P0 is None and log.updates[3].K is not None
    assert len(log.rows_of_P) == 15 and log.x1.shape == (len(log.t1), log.x0.shape[1])


def test_a_filter_or_a_want_that_is_not_there_is_refused(quickstart):
    with pytest.raises(KeyError, match="log: there is no filter 'nobody'; there are 'ins'"):
        quickstart.run(log="nobody")
    with pytest.raises(KeyError, match="observers: there is no filter 'nobody'"):
        quickstart.run(observers={"nobody": print})
    with pytest.raises(ValueError, match="'gain' is nothing to want of a step log; there are step_covariance"):
        quickstart.run(log={"ins": ["gain"]})
    with pytest.raises(TypeError, match="observers\\['ins'\\] is of type 'int'"):
        quickstart.run(observers={"ins": 3})


def test_observers_change_no_number(quickstart, figures_of, logged):
    watched = quickstart.run(seed=3, observers={"ins": lambda record: record.x1})
    assert figures_of(dict(watched.summary)) == figures_of(dict(logged.summary))
    alone = quickstart.run(seed=3)
    assert np.array_equal(watched["ins"]["position"], alone["ins"]["position"])
    assert np.array_equal(logged["ins"]["position"], alone["ins"]["position"])


class Watch:
    wants = ("transition", "update_covariance")

    def __init__(self):
        self.starts, self.steps, self.updates = [], [], []

    def started(self, t, x, P):
        self.starts.append((t, x, P))

    def stepped(self, step):
        self.steps.append((step.t0, step.t1, step.Phi, step.P1, step.t1_ns))

    def offered(self, update):
        self.updates.append((update.t, update.outcome, update.residual, update.P1, update.H))


def test_an_observer_sees_what_the_log_keeps(quickstart, logged):
    watch, log = Watch(), logged["ins"].log
    quickstart.run(seed=3, observers={"ins": watch})
    assert np.array_equal([step[0] for step in watch.steps], log.t0)
    assert np.array_equal([step[1] for step in watch.steps], log.t1)
    assert np.array_equal([step[2] for step in watch.steps], log.Phi)
    assert all(step[3] is None for step in watch.steps)
    assert watch.starts[0][0] == log.starts["t"][0] and np.array_equal(watch.starts[0][2], log.starts["P"][0])
    for (t, outcome, residual, P1, H), update in zip(watch.updates, log.updates):
        assert (t, outcome) == (update.t, update.outcome) and H is None
        assert np.array_equal(residual, update.residual) and np.array_equal(P1, update.P1)


def test_what_is_taken_of_a_record_stays_and_the_record_goes(quickstart):
    kept = []

    def watch(record):
        if isinstance(record, bn.Update) and not kept:
            kept.extend([record, record.residual, record.residual.copy()])

    quickstart.run(observers={"ins": watch})
    record, residual, copy = kept
    assert np.array_equal(residual, copy)
    with pytest.raises(RuntimeError, match="during the call"):
        record.residual


class Mine(Exception):
    pass


def test_an_exception_of_an_observer_ends_the_run_and_is_raised_as_it_is(quickstart, tmp_path):
    calls = []

    def watch(record):
        calls.append(record)
        if len(calls) == 100:
            raise Mine("enough")

    with pytest.raises(Mine, match="enough") as caught:
        quickstart.run(observers={"ins": watch}, out=tmp_path / "out")
    assert len(calls) == 100
    assert caught.traceback[-1].name == "watch"
    assert not (tmp_path / "out").exists()


def test_what_late_samples_void_is_taken_out_of_the_log(project):
    """The log of a run whose samples all came late, in any order, is that of the run in which they came in time."""
    path = project / "configs" / "quickstart.json"
    late = {
        "/filters/ins/history": "2 s",
        "/sources/drive/latency": {"uniform": [0, "1.9 s"]},
        "/evaluate/estimates": "live",
        "/sources/drive/segments": [
            {"do": "still", "duration": "5 s"},
            {"do": "accelerate", "to": "14 m/s", "acceleration": "2 m/s^2"},
        ],
    }
    rewound = []

    class Watch:
        wants = ()

        def rewound(self, t):
            rewound.append(t)

    log = bn.load(path, set=late).run(log=True, observers={"ins": Watch()})["ins"].log
    in_time = {name: value for name, value in late.items() if "latency" not in name}
    ordered = bn.load(path, set=in_time).run(log=True)["ins"].log
    assert len(rewound) > 10
    assert np.array_equal(log.t1, ordered.t1) and np.array_equal(log.P1, ordered.P1)
    assert np.array_equal(log.updates.t, ordered.updates.t) and np.array_equal(log.updates.nis, ordered.updates.nis)
