# SPDX-License-Identifier: Apache-2.0
"""Runs a variant of a study, and reads what it left."""
import concurrent.futures
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent / "compare"))

import judge  # noqa: E402
import names  # noqa: E402
import netcdf  # noqa: E402
import trees  # noqa: E402

CLEAN = "clean"
STUDIES = {"recorded": "configs/faults/matrix.json", "simulated": "configs/faults/simulated.json"}
TIMEOUT = 600  # s, of one run


def data_folder(named):
    """That of the recorded drives, or None."""
    try:
        folder = trees.data_folder(named) / "drives"
    except names.Bad:
        return None
    return folder if folder.is_dir() else None


class Study:
    """One of STUDIES, and the command that runs it."""

    def __init__(self, name, command, drives, library):
        self.name, self.command, self.library = name, command, library
        self.words = ["--var", f"drives={drives}"] if name == "recorded" else []

    def carry_out(self, variant, folder):
        line = [str(self.command), "run", STUDIES[self.name], "--variant", variant, "--out", str(folder), "--quiet"]
        environment = {k: v for k, v in os.environ.items() if not k.startswith("BINNACLE_")}
        environment.update(NO_COLOR="1", LC_ALL="C.UTF-8")
        try:
            done = subprocess.run(line + self.words, cwd=ROOT, env=environment, stdin=subprocess.DEVNULL,
                                  capture_output=True, text=True, errors="replace", timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            raise judge.Bad(f"{variant}: it takes beyond {TIMEOUT} s") from None
        if done.returncode not in (0, 1) or not (folder / "summary.json").exists():
            first = (done.stderr.strip() or "nothing on stderr").split("\n")[0]
            raise judge.Bad(f"{variant}: exit status {done.returncode}: {first}")

    def run(self, variant):
        """(judge.Run, the config as it was run)"""
        with tempfile.TemporaryDirectory(prefix="binnacle-faults-") as scratch:
            folder = Path(scratch) / "out"
            self.carry_out(variant, folder)
            config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
            filters = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["filters"]
            if len(filters) != 1:
                raise judge.Bad(f"{variant}: one filter is judged, not {len(filters)}")
            (name, figures), = filters.items()
            if "verdict" not in figures:
                raise judge.Bad(f"{variant}: this binnacle gives no verdict")
            variables = netcdf.read(self.library, folder / "run.nc")
        start = figures.get("start_s")
        verdict = figures["verdict"]
        return judge.Run(*errors_of(variables, name), verdict["state"], verdict["reasons"], start, scored_from(config, start)), config


def drive_config(name):
    """The matrix's config with the drive of configs/drives/NAME.json and the mounting of its sensor."""
    config = json.loads((ROOT / f"configs/drives/{name}.json").read_text(encoding="utf-8"))
    return config | {"extends": str(ROOT / "configs/faults/matrix.json")}


def carried_out(binary, config, library, words=()):
    """(the figures of its only filter, the variables of run.nc) of a config that is written for one run."""
    with tempfile.TemporaryDirectory(prefix="binnacle-faults-") as scratch:
        file, out = Path(scratch) / "config.json", Path(scratch) / "out"
        file.write_text(json.dumps(config), encoding="utf-8")
        done = subprocess.run([binary, "run", str(file), "--out", str(out), "--quiet", *words], stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if done.returncode not in (0, 1):
            raise judge.Bad((done.stderr.strip() or "nothing on stderr").split("\n")[0])
        (figures,) = json.loads((out / "summary.json").read_text(encoding="utf-8"))["filters"].values()
        return figures, netcdf.read(library, out / "run.nc")


def errors_of(variables, name="ins"):
    """(horizontal error in m, attitude error in deg) by second, of a filter."""
    return (by_second(variables, name, "position_horizontal", "position", 1.0), by_second(variables, name, "attitude", "attitude", 180 / math.pi))


def scored_from(config, start):
    """The instant from which `evaluate` scores."""
    after = config.get("evaluate", {}).get("after", 0)
    if isinstance(after, str) and after.startswith("start+"):
        return (start or 0.0) + judge.seconds(after.removeprefix("start+"))
    return judge.seconds(after)


def times_of(errors, variable, block):
    """References that come at other times than the first have a time of their own, time_BLOCK_…"""
    fitting = {name: other for name, other in errors.items()
               if name.startswith("time") and other.shape == variable.shape[:1]}
    own = sorted(name for name in fitting if name.startswith(f"time_{block}"))
    name = own[0] if own else "time" if "time" in fitting else min(fitting, default=None)
    if name is None:
        raise judge.Bad(f"run.nc: no time of the errors of '{block}'")
    return fitting[name].values()


def by_second(variables, filter_name, name, block, scale):
    """The error (of several components its length) by second; nothing where none was scored."""
    errors = {path[2]: variable for path, variable in variables.items() if path[:2] == (filter_name, "errors") and len(path) == 3}
    variable = errors.get(name)
    if variable is None or not variable.shape or variable.shape[0] == 0:
        return {}
    times, values = times_of(errors, variable, block), variable.values()
    width = variable.shape[1] if len(variable.shape) > 1 else 1
    lengths = (scale * math.sqrt(sum(values[row * width + k] ** 2 for k in range(width))) for row in range(variable.shape[0]))
    return judge.by_second(times, lengths)


def judged(study, chosen, jobs, show):
    """(the clean run, [Cell], [what could not be run]) of the chosen variants, all where none is named; in the study's order."""
    clean, config = study.run(CLEAN)
    judge.limits(clean)
    variants = [name for name in config["study"]["variants"] if name != CLEAN]
    for name in chosen:
        if name not in variants:
            raise judge.Bad(f"{STUDIES[study.name]} has no cell '{name}'")
    variants = [name for name in variants if not chosen or name in chosen]
    cells, failures = [], []
    with concurrent.futures.ThreadPoolExecutor(max(1, jobs)) as pool:
        for name, future in [(name, pool.submit(study.run, name)) for name in variants]:
            try:
                run, config = future.result()
                cells.append(judge.Cell(name, run, clean, config))
                show(cells[-1])
            except judge.Bad as error:
                failures.append(str(error))
            except OSError as error:
                failures.append(f"{name}: {error}")
    return clean, cells, failures

