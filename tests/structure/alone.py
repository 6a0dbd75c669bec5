#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each source and header of the project compiles alone: without unity batches, without a precompiled header.

alone.py PROJECT SCRATCH [--all | --sample N] [--seed TEXT] [--cmake FILE]

Configures PROJECT in SCRATCH with BINNACLE_UNITY=OFF, then parses files one by one (-fsyntax-only). --all takes all of them,
an hour of processor time; else N of them (24), drawn by --seed, which is the commit unless specified.
alone.py --bad COMMAND… parses one file that must fail, and fails if it does not.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path


def parse_only(command):
    """The compiler's words for what a compile command compiles, without output and precompiled header."""
    words, kept, skip = shlex.split(command), [], False
    while words and not re.fullmatch(r"(c[+][+]|g[+][+]|clang[+][+]|cc|gcc|clang)(-[0-9.]+)?", Path(words[0]).name):
        words.pop(0)  # ccache
    for word in words:
        if skip:
            skip = False
        elif word in ("-o", "-include"):
            skip = True
        elif word not in ("-c", "-fpch-preprocess", "-Winvalid-pch"):
            kept.append(word)
    return kept + ["-fsyntax-only"]


def failure_of(job):
    name, words, text, folder = job
    done = subprocess.run(words, input=text, text=True, capture_output=True, cwd=folder, check=False)
    return f"{name} does not compile alone:\n{done.stderr[:2000]}" if done.returncode else ""


def configure(cmake, project, scratch):
    subprocess.run([cmake, "-S", project, "-B", scratch, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DBINNACLE_UNITY=OFF"],
                   check=True, stdout=subprocess.DEVNULL)
    subprocess.run([cmake, "--build", scratch, "--target", "binnacle_header_hash"], check=True, stdout=subprocess.DEVNULL)
    return json.loads((Path(scratch) / "compile_commands.json").read_text(encoding="utf-8"))


def jobs_of(project, commands):
    """(name, words, standard input, folder) of each source, and of each header with the flags of a source near it."""
    jobs, near = [], {}
    for command in commands:
        path = Path(command["file"])
        if not path.is_relative_to(project) or path.is_relative_to(Path(command["directory"])):
            continue  # written by the build
        words = parse_only(command["command"])
        jobs.append((str(path.relative_to(project)), words, None, command["directory"]))
        if path.suffix == ".c":
            continue  # its flags are none for C++
        for folder in (path.parent, *path.parent.parents):
            if folder not in near or len(near[folder][0]) < len(words):  # the source that sees most folders
                near[folder] = ([w for w in words if w != command["file"]], command["directory"])
            if folder == project:
                break
    for part in ("kernel", "plugins", "sdk", "tests"):
        for header in sorted((project / part).rglob("*.hpp")):
            folder = next((f for f in header.parents if f in near), None)
            if {"template", "examples", "bad", "build"} & set(header.parts) or folder in (None, project):
                continue
            words, directory = near[folder]
            jobs.append((str(header.relative_to(project)), words + ["-x", "c++", "-"], f'#include "{header}"\n', directory))
    return jobs


def main():
    if sys.argv[1:2] == ["--bad"]:
        return 0 if failure_of(("the bad file", sys.argv[2:] + ["-fsyntax-only"], None, ".")) else 1
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("project", type=lambda p: Path(p).resolve())
    options.add_argument("scratch")
    options.add_argument("--all", action="store_true")
    options.add_argument("--sample", type=int, default=24)
    options.add_argument("--seed")
    options.add_argument("--cmake", default="cmake")
    given = options.parse_args()
    jobs = jobs_of(given.project, configure(given.cmake, given.project, given.scratch))
    if len(jobs) < 1000:
        sys.exit(f"only {len(jobs)} files were found")
    if not given.all:
        seed = given.seed or subprocess.run(["git", "-C", str(given.project), "rev-parse", "HEAD"], capture_output=True,
                                            text=True, check=False).stdout
        jobs.sort(key=lambda job: hashlib.sha256((seed + job[0]).encode()).digest())
        jobs = jobs[:given.sample]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        failures = [failure for failure in pool.map(failure_of, jobs) if failure]
    for failure in failures:
        print(failure)
    print(f"{len(jobs)} files, {len(failures)} of them do not compile alone")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
