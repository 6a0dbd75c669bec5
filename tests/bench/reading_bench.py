#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How fast csv is read: `tests/bench/reading_bench.py [--quick] [--json]`. Megabytes of text a second of processor: of the csv source
(a file that stays in memory, and gzipped), of `wc -l` and of fast_float on the same file, medians of rounds in one run; then
the memory of `binnacle run` over a file of 300 MB. $BINNACLE names the command."""
import argparse
import gzip
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

PROJECT = Path(os.environ.get("PROJECT", Path(__file__).resolve().parents[2])).resolve()
BINNACLE = Path(os.environ.get("BINNACLE", PROJECT / "build/release/bin/binnacle")).resolve()
BENCH = BINNACLE.parent / "reading_bench"


def write_rows(path, megabytes):
    """Increments at 200 Hz with ten digits, as the bench of results has them; blocks of numbers come again, times do not."""
    rows = [",".join(f"{((i * 7919 + k * 104729) % 1999993 - 999996) / 10 ** (9 + k % 2):.9e}" for k in range(6)) for i in range(4096)]
    with open(path, "w") as file:
        file.write("t_s,wx,wy,wz,fx,fy,fz\n")
        i = written = 0
        while written < megabytes * 1e6:
            written += file.write("".join(f"{(i + k + 1) / 200:.3f},{row}\n" for k, row in enumerate(rows)))
            i += len(rows)


def output_of(*words):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"{words[0]} ended with exit status {done.returncode}")
    return done.stdout


def seconds(way, path):
    if way == "wc":
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        output_of("wc", "-l", path)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return float(output_of(BENCH, way, path).split()[0])


def peak_MiB(folder):
    """Of a run of the config of the bench of results over imu.csv in the folder; the summary has to be there."""
    (folder / "gnss.csv").write_text("t_s,lat,lon,height\n0.005,48,11,500\n")
    command = [BINNACLE, "run", PROJECT / "tests/bench/results/drive.json", "--var", f"data={folder}", "--json"]
    with open(folder / "summary.json", "w") as out:
        child = subprocess.Popen([str(word) for word in command], stdout=out, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    json.loads((folder / "summary.json").read_text())
    if child.returncode not in (0, 1):  # 1: a filter without fixes is lost, and has read all the same
        sys.exit(f"binnacle run ended with exit status {child.returncode}")
    return usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plain, packed = folder / "imu.csv", folder / "imu.csv.gz"
        size = 2 if options.quick else 60  # MB: what it holds stays in memory
        write_rows(plain, size)
        with open(plain, "rb") as source, gzip.open(packed, "wb", compresslevel=6) as to:
            shutil.copyfileobj(source, to)
        megabytes = plain.stat().st_size / 1e6
        ways = {"csv": ("source", plain), "wc": ("wc", plain), "fast_float": ("fast_float", plain), "gz": ("source", packed)}
        times = {way: [] for way in ways}
        for _ in range(3 if options.quick else 7):
            for way, (how, path) in ways.items():
                times[way].append(seconds(how, path))
        found = {f"{way}_MB_per_s": megabytes / max(median(each), 1e-3) for way, each in times.items()}
        found["csv_of_wc"] = found["csv_MB_per_s"] / found["wc_MB_per_s"]
        found["csv_of_fast_float"] = found["csv_MB_per_s"] / found["fast_float_MB_per_s"]
        if not options.quick:
            write_rows(plain, 300)
        found["file_MB"] = plain.stat().st_size / 1e6
        found["rss_MiB"] = peak_MiB(folder)
    if options.json:
        print(json.dumps(found))
        return
    for key, value in found.items():
        print(f"{key:22}{value:10.4g}")


if __name__ == "__main__":
    main()
