# SPDX-License-Identifier: Apache-2.0
"""The step log: what a filter did, step by step, as arrays."""

import numpy as np

from ._core import outcomes as OUTCOMES

KINDS = ("start", "step", "update", "inflation")


class _Ragged:
    """Numbers of several records, one behind the other: those of record i, or None where it has none."""

    def __init__(self, numbers, ends):
        self._numbers, self._begins, self._ends = numbers, np.concatenate(([0], ends[:-1])), ends

    def __getitem__(self, i):
        return self._numbers[self._begins[i] : self._ends[i]] if self._ends[i] > self._begins[i] else None

    def stacked(self, *shape):
        """Of all records, where each has as many numbers; None where none has any."""
        return self._numbers.reshape(len(self._ends), *shape) if len(self._numbers) else None


class LoggedUpdate:
    """What became of one sample. Matrices are (rows, columns) and views of the log; None where the record does not have them.

    .t [s]; .measurement, .outcome, .reason as text; .rows; .nis; .residual (rows,); .S, .R (rows, rows); .H (rows, n); 
    .K (n, rows);
    .delta (n,), the injected error; .update_residual, .update_S; .x0, .x1 stored states before and after; .P0, .P1 (n, n);
    .reset (n, n), None: the identity. n: as many as rows_of_P.
    """

    def __init__(self, log, i):
        self.t, self.measurement = log.t[i], log._measurements[log._measurement[i]]
        self.outcome, self.reason = OUTCOMES[log._outcome[i]], log._reason[i]
        self.rows, self.nis = int(log.rows[i]), float(log.nis[i])
        n = log._n
        shapes = {"H": (self.rows, n), "K": (n, self.rows)}
        shapes.update(dict.fromkeys(("S", "R", "update_S"), (self.rows, self.rows)))
        shapes.update(dict.fromkeys(("P0", "P1", "reset"), (n, n)))
        for name, field in log._fields.items():
            numbers = field[i]
            setattr(self, name, numbers if numbers is None or name not in shapes else numbers.reshape(shapes[name]))

    def __repr__(self):
        return f"<LoggedUpdate of {self.measurement!r} at {self.t} s: {self.outcome}>"


class LoggedUpdates:
    """Every sample: a sequence of LoggedUpdate, each made when asked for. .t (m,) [s], .rows (m,), .nis (m,); .outcome,
    .measurement (m,) as text."""

    def __init__(self, log, t):
        self.t, self.rows, self.nis = t, log["rows"], log["nis"]
        self._outcome, self._reason, self._measurement = log["outcome"], log["reason"], log["measurement"]
        self._measurements, self._n = log["measurements"], len(log["rows_of_P"])
        self._fields = {name: _Ragged(*field) for name, field in log["updates"].items()}

    @property
    def outcome(self):
        return np.asarray(OUTCOMES)[self._outcome]

    @property
    def measurement(self):
        """Its name, (m,)."""
        return np.asarray(self._measurements or [""])[self._measurement]

    def __len__(self):
        return len(self.t)

    def __getitem__(self, i):
        if not -len(self) <= i < len(self):
            raise IndexError(f"update {i} of {len(self)}")
        return LoggedUpdate(self, i % len(self))


class StepLog:
    """All that a filter did, in memory.

    s steps: .t0, .t1 (s,) [s]; .x0, .x1 (s, stored), stored states at the beginning and, a priori, at the end; .P0, .P1, .Phi,
    .Qd (s, n, n). m samples: .updates. .starts: t (k,), x (k, stored), P (k, n, n), where the filter started, anew as well.
    .inflations: where P was opened: t, measurement, and a list each of variances (n,), scales (n,), P0, P1. What was not
    wanted is None.
    .kinds: of all records in the order in which they came, "start", "step", "update", "inflation". .rows_of_P: names of the n
    rows of P. With `history`, what a late sample voids is not there.

    From P of a start: a step makes P ← Phi P Phi' + Qd; an accepted sample P ← T ((I - K H) P (I - K H)' + K R K') T', T its
    reset.
    """

    def __init__(self, log):
        self.rows_of_P = log["rows_of_P"]
        self._kinds = log["kinds"]
        n, stored = len(self.rows_of_P), log["stored"]
        t = {kind: log["times"][self._kinds == i] / 1e9 for i, kind in enumerate(KINDS)}
        self.t0, self.t1 = log["t0"] / 1e9, t["step"]
        for name, field in log["steps"].items():
            shape = (stored,) if name.startswith("x") else (n, n)
            setattr(self, name, _Ragged(*field).stacked(*shape))
        x, P = (_Ragged(*log["starts"][name]) for name in ("x", "P"))
        self.starts = {"t": t["start"], "x": x.stacked(stored), "P": P.stacked(n, n)}
        self.updates = LoggedUpdates(log, t["update"])
        self.inflations = {"t": t["inflation"], "measurement": [log["measurements"][i] for i in log["opened_by"]]}
        for name, field in log["inflations"].items():
            ragged = _Ragged(*field)
            numbers = [ragged[i] for i in range(len(t["inflation"]))]
            self.inflations[name] = [x if x is None or name in ("variances", "scales") else x.reshape(n, n) for x in numbers]

    @property
    def kinds(self):
        return np.asarray(KINDS)[self._kinds]

    def __repr__(self):
        return f"<StepLog: {len(self.t1)} steps, {len(self.updates)} samples, {len(self.rows_of_P)} rows of P>"
