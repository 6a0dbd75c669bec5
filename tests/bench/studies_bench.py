#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a study costs: `tests/bench/studies_bench.py [--runs N] [--repeats N] [--baseline COMMAND] [--json]`, of configs/transfer_alignment/table3.json.

Processor time of its ten variants together and of each alone, whose figures must be the same to the last digit; wall time of
one thread over two, and of one rank over two. Ranks are timed under mpirun in both, so its start is in both. Of repeats, which go round in
turn, the best counts. --baseline is the command of another build, which does the same study in the same rounds."""
import argparse
import csv
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time

BINNACLE = os.path.abspath(os.environ.get("BINNACLE", "build/release/bin/binnacle"))
PROJECT = os.path.abspath(os.environ.get("PROJECT", "."))
CONFIG = f"{PROJECT}/configs/transfer_alignment/table3.json"
SCALES = ["x1", "x1.5", "x2", "x3", "x5", "x7", "x10"]
ERRORS = ["align/attitude.yaw/final", "align/attitude.tilt/final"]
ADAPTIVE = ["adaptive literal", "adaptive nominal start", "adaptive hold"]


def timed(*words):
    """Wall and processor time [s] of a command and all that it started."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    done = subprocess.run(words, capture_output=True, text=True, env=environment)
    wall, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}: {done.stderr}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def alone(variant, folder):
    """A config of this variant and no other."""
    without = {name: None for name in ADAPTIVE if name != variant}
    dimensions = {"scale": {name: None for name in SCALES if f"ekf {name}" != variant}} if variant.startswith("ekf") else None
    study = {"table": None, "variants": without, "dimensions": dimensions}
    if variant.startswith("ekf"):  # which has no noise that it adapts
        study["metrics"] = [{"metric": name, "unit": "mil"} for name in ERRORS]
    path = os.path.join(folder, f"{variant}.json")
    with open(path, "w") as file:
        json.dump({"extends": CONFIG, "study": study}, file)
    return path


def figures(folder, variant):
    """Its lines of study.csv, as text, that have a value: numbers come back from it bit for bit."""
    with open(os.path.join(folder, "study.csv")) as file:
        lines = list(csv.DictReader(file))
    return [line for line in lines if line["variant"] == variant and line["value"]]


def together_and_alone(runs):
    """Processor times [s]."""
    with tempfile.TemporaryDirectory() as folder:
        common = ["--runs", runs, "--jobs", "1", "--quiet", "--out"]
        _, together = timed(BINNACLE, "study", CONFIG, *common, f"{folder}/all")
        apart = 0
        for variant in [f"ekf {scale}" for scale in SCALES] + ADAPTIVE:
            apart += timed(BINNACLE, "study", alone(variant, folder), *common, f"{folder}/{variant}")[1]
            found = figures(f"{folder}/{variant}", variant)
            if not found or figures(f"{folder}/all", variant) != found:
                sys.exit(f"variant '{variant}' has other figures alone")
        return together, apart


def ways(baseline):
    study = ["study", CONFIG, "--quiet", "--runs"]
    all_ways = {"1 thread": ([BINNACLE, *study], "1"), "2 threads": ([BINNACLE, *study], "2")}
    if baseline:
        all_ways["baseline, 1 thread"] = ([baseline, *study], "1")
        all_ways["baseline, 2 threads"] = ([baseline, *study], "2")
    if shutil.which("mpirun"):
        for ranks in ("1", "2"):
            name = "1 rank" if ranks == "1" else "2 ranks"
            all_ways[name] = (["mpirun", "--oversubscribe", "-n", ranks, BINNACLE, *study], "1")
    else:
        print("SKIPPED: no mpirun", file=sys.stderr)
    return all_ways


def measure(options):
    runs, best = str(options.runs), {}
    for _ in range(options.repeats):
        for name, (words, jobs) in ways(options.baseline).items():
            wall, processor = timed(*words, runs, "--jobs", jobs)
            old = best.get(name, {"wall_s": wall, "processor_s": processor})
            best[name] = {"wall_s": min(wall, old["wall_s"]), "processor_s": min(processor, old["processor_s"])}
    together, apart = together_and_alone(runs)
    found = {"runs": options.runs, "repeats": options.repeats, "load": os.getloadavg()[0], "ways": best,
             "together_s": together, "apart_s": apart, "together_over_apart": together / apart,
             "threads": best["1 thread"]["wall_s"] / best["2 threads"]["wall_s"],
             "threads_at_most": 2 * best["1 thread"]["processor_s"] / best["2 threads"]["processor_s"]}
    if "2 ranks" in best:
        found["ranks"] = best["1 rank"]["wall_s"] / best["2 ranks"]["wall_s"]
    if options.baseline:
        found["over_baseline"] = best["1 thread"]["processor_s"] / best["baseline, 1 thread"]["processor_s"]
    return found


def show(found):
    print(f"configs/transfer_alignment/table3.json, {found['runs']} runs of 10 variants, best of {found['repeats']}; {os.cpu_count()} processors, load {found['load']:.1f}")
    for name, way in found["ways"].items():
        print(f"  {name:20} {way['wall_s']:8.2f} s wall {way['processor_s']:8.2f} s processor")
    print(f"all variants together {found['together_s']:.2f} s, each alone {found['apart_s']:.2f} s: {found['together_over_apart']:.3f}, the same figures")
    print(f"two threads {found['threads']:.2f} x (by processor time at most {found['threads_at_most']:.2f} x)")
    if "ranks" in found:
        print(f"two ranks {found['ranks']:.2f} x, mpirun's start in both")
    if "over_baseline" in found:
        print(f"processor time over the baseline's: {found['over_baseline']:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--baseline")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = measure(options)
    print(json.dumps(found, indent=2)) if options.json else show(found)


if __name__ == "__main__":
    main()
