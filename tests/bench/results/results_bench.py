#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What results cost a run: `results_bench.py [--batches N] [--json] [--data FOLDER] [--epochs N] [--baseline COMMAND]`. BINNACLE is the
command.

In each batch every kind of results is run once, and held against the run without results of the same batch: CPU (user and system,
all threads), wall time, and the most memory. Printed are medians over the batches; the ratios are the medians of ratios.
--baseline is the command of another build, run without results in the same batches: "of baseline" is CPU over its CPU.
"""
import argparse
import json
import os
import platform
import shutil
import statistics
import tempfile
import time
from pathlib import Path

import data

HERE = Path(__file__).resolve().parent
KINDS = {
    "none": None,
    "nc": ["--only", "nc"],
    "nc, deflate 1": ["--only", "nc", "--compress", "1"],
    "csv": ["--only", "csv"],
    "page": ["--only", "page"],
    "all": ["--only", "nc,csv,page"],
}


def measure(command, log):
    """CPU, wall time and peak memory of a command, as the system counts them."""
    begin = time.monotonic()
    child = os.fork()
    if child == 0:
        output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.execvp(command[0], command)
    _, status, usage = os.wait4(child, 0)
    wall = time.monotonic() - begin
    if status != 0:
        raise SystemExit(f"{' '.join(map(str, command))}: status {status}\n{Path(log).read_text()}")
    return {"cpu_s": usage.ru_utime + usage.ru_stime, "wall_s": wall, "rss_mib": usage.ru_maxrss / 1024}


def run_batch(folder, kinds, baseline):
    binnacle = os.environ.get("BINNACLE", "binnacle")
    batch = {}
    if baseline:
        command = [baseline, "run", HERE / "drive.json", "--var", f"data={folder}", "--quiet"]
        batch["baseline"] = {**measure(list(map(str, command)), folder / "log.txt"), "mb": 0.0}
    for name in kinds:
        options = KINDS[name]
        out = folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        command = [binnacle, "run", HERE / "drive.json", "--var", f"data={folder}", "--quiet"]
        if options is not None:
            command += ["--out", out, *options]
        batch[name] = measure(list(map(str, command)), folder / "log.txt")
        batch[name]["mb"] = sum(file.stat().st_size for file in out.glob("*")) / 1e6 if out.exists() else 0.0
    return batch


def summarize(batches):
    figures = {}
    for name in batches[0]:
        figure = {key: statistics.median(batch[name][key] for batch in batches) for key in batches[0][name]}
        for key in ("cpu_s", "wall_s"):
            ratios = [batch[name][key] / batch["none"][key] for batch in batches]
            figure[key.replace("_s", "_ratio")] = statistics.median(ratios)
        if "baseline" in batches[0]:
            figure["of_baseline"] = statistics.median(batch[name]["cpu_s"] / batch["baseline"]["cpu_s"] for batch in batches)
        figures[name] = figure
    return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--batches", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--epochs", type=int, default=672399)
    parser.add_argument("--baseline")
    parser.add_argument("--data", type=Path, help="a folder that data.py filled; else one is made")
    parser.add_argument("--kinds", default=";".join(KINDS), help="some of: " + ";".join(KINDS))
    arguments = parser.parse_args()
    kinds = ["none"] + [kind for kind in arguments.kinds.split(";") if kind != "none"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = (arguments.data or Path(scratch)).resolve()
        if not (folder / "imu.csv").exists():
            data.prepare(folder, arguments.epochs)
        batches = [run_batch(folder, kinds, arguments.baseline) for _ in range(arguments.batches)]
        shutil.rmtree(folder / "out", ignore_errors=True)
    figures = summarize(batches)
    if arguments.json:
        machine = {"machine": platform.node(), "processors": os.cpu_count(), "batches": arguments.batches}
        print(json.dumps({**machine, "results": figures}, indent=2))
        return
    print(f"{'results':15} {'CPU':>8} {'ratio':>6} {'wall':>8} {'ratio':>6} {'memory':>9} {'files':>9}")
    for name, figure in figures.items():
        print(f"{name:15} {figure['cpu_s']:6.2f} s {figure['cpu_ratio']:6.2f} {figure['wall_s']:6.2f} s "
              f"{figure['wall_ratio']:6.2f} {figure['rss_mib']:5.0f} MiB {figure['mb']:6.0f} MB"
              + (f"  {figure['of_baseline']:.2f} of baseline" if "of_baseline" in figure else ""))


if __name__ == "__main__":
    main()
