# SPDX-License-Identifier: Apache-2.0
"""What is wrong, noticed and recovered: configs/faults/README.md has the definitions in words."""
import math
import re

WINDOW = 10            # s: over which the horizontal error is taken
WRONG_FACTOR = 3       # of the clean run's largest
WRONG_MORE = (1.0, 1.0)      # and beyond that: m, deg
BACK_FACTOR = 2        # of the clean run's, second by second
BACK_MORE = (0.5, 0.5)       # and beyond that: m, deg
BACK_WITHIN = 30       # s after the fault
BACK_SHARE = 0.9       # of the cells that are wrong for a while
ALONG, WHILE = "all along", "for a while"
AT_START = "heading at the start"
UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0}


class Bad(Exception):
    """What can not be judged, in words."""


def seconds(value):
    """Of a time of a config: a number, or text with a unit."""
    if isinstance(value, (int, float)):
        return float(value)
    found = re.fullmatch(r"\s*([-+0-9.eE]+)\s*([a-z]+)\s*", value)
    if not found or found.group(2) not in UNITS:
        raise Bad(f"'{value}' is not a time")
    return float(found.group(1)) * UNITS[found.group(2)]


def by_second(times, values):
    """{whole second: root mean square of the values in it}; what is not a number is an infinite error."""
    sums = {}
    for t, value in zip(times, values):
        square = value * value if math.isfinite(value) else math.inf
        total, count = sums.get(math.floor(t), (0.0, 0))
        sums[math.floor(t)] = (total + square, count + 1)
    return {second: math.sqrt(total / count) for second, (total, count) in sums.items()}


def largest_window(errors, after):
    """The largest root mean square over WINDOW successive seconds from `after` on; None where there is no such window."""
    largest = None
    for first in sorted(errors):
        there = [errors[s] for s in range(first, first + WINDOW) if s in errors]
        if first < after or 2 * len(there) < WINDOW or first + WINDOW - 1 > max(errors):
            continue
        rms = math.sqrt(sum(e * e for e in there) / len(there))
        largest = rms if largest is None else max(largest, rms)
    return largest


def largest(errors, after):
    return max((e for s, e in errors.items() if s >= after), default=None)


class Run:
    """One run: errors by second (m; deg), the verdict, and the span that is scored."""

    def __init__(self, horizontal, attitude, state, reasons, start, after):
        self.horizontal, self.attitude = horizontal, attitude
        self.state, self.reasons, self.start = state, reasons, start
        self.figures = (largest_window(horizontal, after), largest(attitude, after))


def limits(clean):
    """Beyond which a run is wrong: m, deg."""
    if None in clean.figures:
        raise Bad("the clean run has no errors to compare with")
    return tuple(WRONG_FACTOR * figure + more for figure, more in zip(clean.figures, WRONG_MORE))


def is_wrong(run, clean):
    """A run that gave nothing to compare is wrong too."""
    return any(figure is None or not figure <= limit for figure, limit in zip(run.figures, limits(clean)))


def fault_of(cell, config, start):
    """(kind, begin, end) from the faults of a config as it was run; what has no end is wrong all along, from the filter's start on."""
    start = 0.0 if start is None else start
    faults = [fault for transform in config.get("transforms", {}).values() if transform.get("type") == "faults"
              for fault in transform.get("faults", [])]
    if any("until" in fault for fault in faults):
        if any(fault.get("since", "zero") != "zero" or "until" not in fault for fault in faults):
            raise Bad(f"{cell}: faults that begin at the channel's start, or of which only some end, are not judged")
        return WHILE, min(seconds(fault.get("from", start)) for fault in faults), max(seconds(fault["until"]) for fault in faults)
    return (WHILE, start, start) if cell.startswith(AT_START) else (ALONG, start, None)


def _key(reason):
    return reason["code"], reason.get("measurement"), reason.get("part"), tuple(reason.get("rows", ()))


def reasons_of_fault(run, clean):
    """Those that the clean run does not have as well."""
    known = {_key(reason) for reason in clean.reasons}
    return [reason for reason in run.reasons if _key(reason) not in known]


def noticed(run, clean, begin):
    """Seconds from the fault's begin to the instant that the earliest reason names; a window may begin before the fault. None: no reason names one."""
    times = [reason["since_s"] for reason in reasons_of_fault(run, clean) if "since_s" in reason]
    return max(0.0, min(times) - begin) if times else None


def recovered(run, clean, end):
    """Seconds from the fault's end to the second from which both errors stay back, to the end of the data; None: they do not."""
    def is_back(second):
        for errors, right, more in zip((run.horizontal, run.attitude), (clean.horizontal, clean.attitude), BACK_MORE):
            if second in right and not errors.get(second, math.inf) <= BACK_FACTOR * right[second] + more:
                return False
        return True

    after = [s for s in sorted(clean.horizontal.keys() | clean.attitude.keys()) if s >= end]
    back = None
    for second in reversed(after):
        if not is_back(second):
            break
        back = second
    if back is None:
        return None
    return 0.0 if back == after[0] else back - end


class Cell:
    """A variant, judged."""

    def __init__(self, name, run, clean, config):
        self.name, self.run = name, run
        self.kind, self.begin, self.end = fault_of(name, config, run.start)
        self.wrong = is_wrong(run, clean)
        self.reasons = reasons_of_fault(run, clean)
        self.noticed = noticed(run, clean, self.begin)
        self.recovered = recovered(run, clean, self.end) if self.kind == WHILE else None

    @property
    def state(self):
        return self.run.state

    @property
    def is_silent(self):
        """Wrong, and the verdict says ok."""
        return self.wrong and self.state == "ok"

    @property
    def is_back(self):
        return self.recovered is not None and self.recovered <= BACK_WITHIN


def back(cells):
    """(how many are back in time, of how many that are wrong for a while)"""
    a_while = [cell for cell in cells if cell.kind == WHILE]
    return sum(cell.is_back for cell in a_while), len(a_while)
