# SPDX-License-Identifier: Apache-2.0
"""A composition inside your program: samples are pushed, estimates are read."""

import numpy as np

from . import _core
from ._verbs import _streams


class Session(_core.Session):
    """One running composition: all of its filters and transforms, none of its sources. Made by Composition.session().

        imu, position = s.channel("imu"), s.block("ins/position")
        imu.push(t0, t, fields)                 # or s.push("imu", t0, t, fields), which looks the name up
        position.read()

    Times are seconds or numpy.timedelta64, numbers are in SI. What is wrong in a call is refused before anything changes:
    KeyError for names (with the nearest), ValueError and TypeError for sizes, times and types, FilterError where a plugin
    fails. One thread at a time uses a session; a second one is refused (RuntimeError). push() and push_many()
    release the GIL, the readers hold it. Where a filter is meant and there is only one, its name may be left out.
    """

    __slots__ = ()

    def __init__(self, loaded, seed=0, run=0, estimates="live"):
        super().__init__(loaded, *_streams(seed, run), estimates)

    # ---- samples

    def channel(self, name):
        """A handle of a channel, "imu": .push(), .add(), .fields, .row_fields, .covariance_of, .units, .counts()."""
        return self._channel(name)

    def push_many(self, channel, t0s, ts, arrays):
        """Samples of a channel one after another, each an instant of its own, as push() takes them one by one.

        channel: name or handle. ts: (n,) ends, t0s: (n,) begins of the intervals, NaN or NaT where a sample has none, or None
        for instants. arrays: (n, fields) float64 [SI], read where they lie if their rows are contiguous, else copied. All is
        checked before the first is pushed. The GIL is released; Ctrl-C stops between two samples (KeyboardInterrupt).
        """
        index = channel.index if isinstance(channel, _core.Channel) else self._channel(channel).index
        _core.push_many(self, index, t0s, ts, arrays)

    def commit(self, t):
        """Works on what was added for the instant t: inputs first, then measurements in the order of the config."""
        self._commit(t)

    def instant(self, t):
        """Several samples of one instant: `with s.instant(t) as i: i.push("imu", t0, fields); i.push("fix", None, fields)`."""
        return Instant(self, t)

    # ---- estimates

    def block(self, name):
        """A handle of a block, "ins/position": .read(), .sigma(), .covariance(), .outputs, .units."""
        return self._block(name)

    def read(self, block, out=None):
        """Readable outputs of a block, (n,) [SI]: a new array, or written into `out`. NaN before the filter has started."""
        return self._block(block).read(out)

    def sigma(self, block, out=None):
        """Standard deviations of the same, to first order. NaN before the start."""
        return self._block(block).sigma(out)

    def covariance(self, name=""):
        """P of a filter, "ins", (n, n) as rows() names it, or its part of a block, "ins/position". A copy."""
        if "/" in name or (name and name not in self.filters):
            return self._block(name).covariance()
        return self._covariance(name)

    def rows(self, filter=""):
        """What the rows of P are: "position.north", of each estimated or considered error component."""
        return self._rows(filter)

    def state(self, filter=""):
        """The stored state, (n,): of all blocks, one after another. A copy."""
        return self._state(filter)

    # ---- how it fares

    @property
    def filters(self):
        """Names, in the order of the config."""
        return self._filters

    def time(self, filter=""):
        """Of the estimates [s]; None before the filter has started."""
        return _seconds(self._time(filter))

    def time_ns(self, filter=""):
        """The same in nanoseconds, exact."""
        return self._time(filter)

    def start_time(self, filter=""):
        """When it started [s]; None before."""
        return _seconds(self._start_time(filter))

    def started(self, filter=""):
        """Whether it has its initial values."""
        return self._started(filter)

    def healthy(self, filter=""):
        """False once it broke: diagnosis() says why, and it takes no more samples."""
        return self._healthy(filter)

    def diagnosis(self, filter=""):
        """Why it broke, or ""."""
        return self._diagnosis(filter)

    def verdict(self, filter=""):
        """Whether its estimates hold so far: "ok", "doubtful" or "lost", by the limits of its "trust"; "ok" before started()."""
        return self._verdict(filter)

    def reasons(self, filter=""):
        """Why it is not "ok": a list of Diagnostic (B100 to B110)."""
        return self._reasons(filter)

    def notes(self, filter=""):
        """What its models noted: a list of Diagnostic (B083)."""
        return self._notes(filter)

    def counts(self, measurement):
        """What became of a measurement's samples, "ins/fix": a dict with "offered", "accepted", "gated", "late",
        "unsupported", "invalid", "withheld", "rejected", "before_start", "recoveries", "rows_used", "rows_left_out",
        "replayed", "nis_mean" (NaN where none was accepted), "dof_mean", "last_reason". Of channels: channel().counts().
        """
        return self._counts(measurement)

    def filter_counts(self, filter=""):
        """{"steps", "input_gaps" (bridged), "seconds" (of computing, estimated), "longest_lag" [s]}"""
        return self._filter_counts(filter)

    # ---- snapshots

    def snapshot(self):
        """All that this run is, as bytes: restored into a session of the same composition it goes on bit for bit."""
        return self._snapshot()

    def restore(self, snapshot):
        """Goes back to a snapshot. ConfigError (B082) where it is of another composition: then nothing changes."""
        self._restore(bytes(snapshot))

    def reset(self, seed=0, run=0):
        """Back to before the first sample."""
        self._reset(*_streams(seed, run))


class Instant:
    """Samples of one instant. It is worked on where the `with` ends, also by an exception: what was pushed is in it."""

    def __init__(self, session, t):
        self._session, self._t = session, t
        self._is_empty = True

    def __enter__(self):
        return self

    def push(self, channel, t0, fields, rows=None, covariance=None):
        """As Session.push() has it, at most one a channel. channel: name or handle."""
        to = channel if isinstance(channel, _core.Channel) else self._session.channel(channel)
        to.add(t0, self._t, fields, rows, covariance)
        self._is_empty = False

    def __exit__(self, *exception):
        if not self._is_empty:
            self._session.commit(self._t)


def _seconds(t_ns):
    return None if t_ns is None else float(np.float64(t_ns) * 1e-9)
