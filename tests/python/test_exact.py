# SPDX-License-Identifier: Apache-2.0
"""Every config of the project gives the same bits by the package as by the command: figures, estimates, errors, innovations.

run, study and covariance of each, as tests/compare/plan.json has them. By default those are compared whose command takes no
more than BINNACLE_EXACT_SECONDS (0.4) of processor time; the others are skipped, and the skip says so. With 10000 it is all of
them.
"""

import json
import math
import os
import pathlib
import resource
import signal
import subprocess
import sys

import binnacle as bn
import numpy as np
import pytest

PROJECT = pathlib.Path(os.environ["BINNACLE_PROJECT"])
CONFIGS = PROJECT / "configs"
LIMIT = float(os.environ.get("BINNACLE_EXACT_SECONDS", "0.4"))
DATA = pathlib.Path(os.environ.get("BINNACLE_DATA", PROJECT / ".." / "shared" / "data")).resolve()

sys.path.insert(0, str(PROJECT / "tests" / "compare"))
from commands import REFUSED, Plan, data_of  # noqa: E402

PLAN = Plan.read(PROJECT / "tests" / "compare" / "plan.json")
NAMES = sorted(str(path.relative_to(CONFIGS)) for path in CONFIGS.rglob("*.json"))


class Case:
    """A config, with the words that the plan adds, for the command and for the package."""

    def __init__(self, verb, name, scratch):
        data = data_of(CONFIGS, name)
        missing = sorted(kind for kind in data.values() if not (DATA / kind).is_dir())
        if missing:
            pytest.skip(f"no recorded data: {', '.join(missing)}")
        self.verb, self.path, self.scratch = verb, CONFIGS / name, scratch
        self.words = [word.replace("{scratch}", str(scratch)) for word in PLAN.words(verb, name)]
        for variable, kind in sorted(data.items()):
            self.words += ["--var", f"{variable}={DATA / kind}"]
        self.stdin = PLAN.stdin(name).replace("{scratch}", str(scratch))
        (scratch / "data").mkdir(parents=True)
        for first in PLAN.before(name):
            words = [word.replace("{scratch}", str(scratch)) for word in PLAN.words("run", first)]
            line = [os.environ["BINNACLE_COMMAND"], "run", CONFIGS / first, *words, "--quiet"]
            subprocess.run(line, cwd=PROJECT, check=True)

    def option(self, name):
        return [after for word, after in zip(self.words, self.words[1:]) if word == name]

    def command(self, *more):
        """Skips what takes too long. None where the config is refused."""
        line = [os.environ["BINNACLE_COMMAND"], self.verb, str(self.path), *self.words, *more, "--quiet"]
        limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(LIMIT), math.ceil(LIMIT) + 1))  # noqa: E731
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        with open(self.stdin, "rb") as given:
            done = subprocess.run(line, cwd=PROJECT, stdin=given, capture_output=True, text=True, preexec_fn=limit)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if done.returncode == -signal.SIGXCPU or spent > LIMIT:
            pytest.skip(f"takes longer than {LIMIT} s; BINNACLE_EXACT_SECONDS=10000 compares it too")
        assert done.returncode in (0, 1, REFUSED), done.stderr
        return None if done.returncode == REFUSED else done.stdout

    def load(self):
        sets = dict(word.split("=", 1) for word in self.option("--set"))
        return bn.load(self.path, vars=dict(word.split("=", 1) for word in self.option("--var")), set=sets)

    def with_stdin(self, work):
        kept = os.dup(0)
        try:
            with open(self.stdin, "rb") as given:
                os.dup2(given.fileno(), 0)
            return work()
        finally:
            os.dup2(kept, 0)
            os.close(kept)


def figures(value):
    """Without times of the clock, and without what sinks report of the network."""
    if isinstance(value, dict):
        times = ("wall_s", "filter_s", "live", "longest_lag_s")
        return {key: figures(each) for key, each in value.items() if key not in times}
    if isinstance(value, list):
        return [figures(each) for each in value if not (isinstance(each, str) and "://" in each)]
    return value


def bits(array):
    array = np.ascontiguousarray(array)
    return array.view(np.int64) if array.dtype == np.float64 else array


def same_bits(a, b):
    if a is None or b is None:
        return a is b
    a, b = np.asarray(a), np.asarray(b)
    nan = np.isnan(a) & np.isnan(b) if a.dtype == b.dtype == np.float64 and a.shape == b.shape else False
    return a.shape == b.shape and bool(np.all((bits(a) == bits(b)) | nan))


def compare_filters(ours, theirs):
    assert list(ours) == list(theirs)
    assert same_bits(ours.t, theirs.t)
    for names, others in ((ours, theirs), (ours.others, theirs.others), (ours.errors, theirs.errors)):
        assert sorted(names) == sorted(others)
        for name in names:
            assert same_bits(names[name], others[name]), name
            assert same_bits(names[name].sigma, others[name].sigma), name
            assert same_bits(names[name].t, others[name].t), name
    assert list(ours.innovations) == list(theirs.innovations)
    for name, a in ours.innovations.items():
        b = theirs.innovations[name]
        for field in ("t", "outcome_code", "reason", "nis", "rows"):
            assert same_bits(getattr(a, field), getattr(b, field)), (name, field)
        # The file has the rows of a sample group by group.
        order = np.lexsort((np.arange(len(a.sample)), a.group, a.sample))
        for field in ("group", "key", "residual", "sigma", "noise"):
            assert same_bits(getattr(a, field)[order], getattr(b, field)), (name, field)


@pytest.mark.parametrize("name", NAMES)
def test_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(PROJECT)
    case = Case("run", name, tmp_path)
    if case.command("--out", str(tmp_path / "out")) is None:
        with pytest.raises(bn.ConfigError):
            case.load().run()
        return
    ours, theirs = case.with_stdin(lambda: case.load().run()), bn.open(tmp_path / "out")
    assert figures(ours.summary) == figures(theirs.summary)
    assert list(ours) == list(theirs)
    for filter in ours:
        compare_filters(ours[filter], theirs[filter])


@pytest.mark.parametrize("name", NAMES)
def test_study(name, tmp_path, monkeypatch):
    monkeypatch.chdir(PROJECT)
    case = Case("study", name, tmp_path)
    if case.command("--out", str(tmp_path / "out")) is None:
        with pytest.raises(bn.ConfigError):
            case.load().study(runs=1)
        return
    ours, theirs = case.load().study(int(case.option("--runs")[0]), 2), bn.open(tmp_path / "out")
    theirs = theirs if isinstance(theirs, bn.StudyResult) else theirs[1]
    assert figures(ours.summary) == figures(theirs.summary)
    assert list(ours) == list(theirs)
    for variant in ours:
        assert list(ours[variant]) == list(theirs[variant])
        for metric in ours[variant]:
            assert same_bits(ours[variant][metric], theirs[variant][metric]), (variant, metric)


@pytest.mark.parametrize("name", NAMES)
def test_covariance(name, tmp_path, monkeypatch):
    monkeypatch.chdir(PROJECT)
    case = Case("covariance", name, tmp_path)
    printed = case.command("--json")
    if printed is None:
        with pytest.raises(bn.ConfigError):
            case.load().covariance()
        return
    assert figures(dict(case.load().covariance())) == figures(json.loads(printed))
