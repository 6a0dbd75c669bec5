#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws mutants of the C++ of kernel, plugins and sdk, and builds all of them at once, each behind a switch.

draw.py draw --seed S --count N --project DIR --copy FOLDER   clones DIR's HEAD into FOLDER, rewrites it, writes FOLDER/mutants.jsonl
draw.py build --copy FOLDER                                   builds FOLDER; mutants that do not compile are dropped
README.md describes both, and run.py, which runs the tests.
"""
import argparse
import concurrent.futures
import functools
import json
import random
import re
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE.parent / "structure")]
import alone  # noqa: E402
import statements  # noqa: E402

LEFT_OUT = {"examples", "template", "abi.hpp"}
HEADER = HERE / "binnacle_mutants.hpp"
SPARE = 1.05  # of the mutants that compile alone: a template may fail only where it is used
DANGEROUS = re.compile(r"\b(fork|kill|remove_all)\(")  # a mutant may end or delete what it should not
PLACE = re.compile(r"([^\s:]+\.[ch]pp):(\d+)[:,]")


def say(text):
    print(text, flush=True)


def git(folder, *words):
    return subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True).stdout


def drawn(folder, seed, count):
    """Mutants in the order of drawing: each line of code that can be changed is as likely as any other, once a statement."""
    rng, lines, sources, taken, mutants = random.Random(seed), {}, {}, set(), []
    for path in sorted(path for part in ("kernel", "plugins", "sdk") for path in (folder / part).rglob("*.[ch]pp")):
        name = str(path.relative_to(folder))
        text = path.read_text(encoding="utf-8")
        if not LEFT_OUT & set(Path(name).parts) and not DANGEROUS.search(text):
            sources[name] = statements.Source(text)
            for site in statements.sites(sources[name], rng):
                lines.setdefault((name, sources[name].line(site[2])), []).append(site)
    say(f"{len(sources)} files, {len(lines)} lines that can be changed, {sum(map(len, lines.values()))} mutants")
    for name, line in rng.sample(sorted(lines), len(lines)):
        record, kind, at, new = rng.choice(lines[name, line])
        if (name, record.first) in taken or len(mutants) == count:
            continue
        taken.add((name, record.first))
        source, number = sources[name], len(mutants)
        original, changed = source.one_line(record.first, record.last), source.one_line(record.first, record.last, {at: new})
        mutants.append({"id": number, "file": name, "line": line, "kind": kind, "at": source.at(at), "original": original,
                        "mutated": {"dropped": "", "negated": f"!({original})"}.get(kind, changed),
                        "lines": [source.line(record.first), source.line(record.last)],
                        "edits": statements.rewritten(source, record, kind, at, new, number)})
    return mutants


@functools.cache
def text_of(copy, name):
    return git(copy, "show", f"HEAD:{name}")


def rewrite(copy, mutants):
    """Writes each file of the copy with these mutants; a file that stays as it is keeps its time."""
    by_file = {}
    for mutant in mutants:
        by_file.setdefault(mutant["file"], []).extend(mutant["edits"])
    for name in sorted({*by_file, *git(copy, "diff", "--name-only").split()}):
        text = text_of(copy, name)
        for start, end, new in sorted(by_file.get(name, []), reverse=True):
            text = text[:start] + new + text[end:]
        if name in by_file:  # in place of the licence, so that lines keep their numbers
            text = f'#include "{copy / HEADER.name}"\n' + text.split("\n", 1)[1]
        if (copy / name).read_text(encoding="utf-8") != text:
            (copy / name).write_text(text, encoding="utf-8")


def blamed(copy, mutants, errors):
    """Numbers of the mutants that a compiler's words are about: those at an error, else those that its context names."""
    where, ids = {}, set()
    for mutant in mutants:
        for line in range(mutant["lines"][0], mutant["lines"][1] + 1):
            where.setdefault((str(copy / mutant["file"]), line), set()).add(mutant["id"])

    def of(text):
        return set().union(*(where.get((str((copy / path).resolve()), int(line)), set()) for path, line in PLACE.findall(text)))

    for block in re.split(r"\n(?=[^\n]*: In |In file included)", errors):
        for line in block.splitlines():
            if " error: " in line:
                ids |= of(line) or of(block)
    return ids or (of(errors) if " error: " in errors else set())  # a build that was interrupted has warnings alone


def compiled(job):
    _, words, text, folder = job
    done = subprocess.run(words + ["-w"], input=text, text=True, capture_output=True, cwd=folder, check=False)
    return done.stderr if done.returncode else ""


def draw(options):
    copy = options.copy.resolve()
    if not copy.exists():
        subprocess.run(["git", "clone", "--quiet", "--shared", str(options.project.resolve()), str(copy)], check=True)
    git(copy, "checkout", "--quiet", ".")
    shutil.copy(HEADER, copy)
    jobs = {job[0]: job for job in alone.jobs_of(copy, alone.configure("cmake", copy, copy / "alone"))}
    mutants = [m for m in drawn(copy, options.seed, int(options.count * options.surplus)) if m["file"] in jobs]
    pending = sorted({m["file"] for m in mutants})
    while pending:  # each file alone; those that fail again, without the mutants that are blamed
        rewrite(copy, mutants)
        say(f"{len(mutants)} mutants, {len(pending)} files to compile")
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            failed = {n: words for n, words in zip(pending, pool.map(lambda n: compiled(jobs[n]), pending)) if words}
        dropped = set().union(*(blamed(copy, mutants, words) or {m["id"] for m in mutants if m["file"] == n} for n, words in failed.items()))
        for mutant in mutants:
            if mutant["id"] in dropped:
                say(f"  does not compile: {mutant['file']}:{mutant['line']} {mutant['kind']}: {mutant['mutated'][:100]}")
        mutants = [m for m in mutants if m["id"] not in dropped]
        pending = sorted(set(failed) & {m["file"] for m in mutants})
    mutants = mutants[:int(options.count * SPARE)]
    rewrite(copy, mutants)
    save(copy, {"seed": options.seed, "count": options.count, "commit": git(copy, "rev-parse", "HEAD").strip()}, mutants)
    say(f"{len(mutants)} mutants in {copy}, {options.count} wanted, seed {options.seed}")


def save(copy, facts, mutants):
    (copy / "mutants.jsonl").write_text("".join(json.dumps(line) + "\n" for line in [facts, *mutants]), encoding="utf-8")


def load(copy):
    facts, *mutants = map(json.loads, (copy / "mutants.jsonl").read_text(encoding="utf-8").splitlines())
    return facts, mutants


def build(options):
    copy = options.copy.resolve()
    facts, mutants = load(copy)
    subprocess.run(["cmake", "--preset", "release", "-DBINNACLE_WERROR=OFF"], cwd=copy, check=True, stdout=subprocess.DEVNULL)
    while True:
        with (copy / "build.log").open("w") as log:
            done = subprocess.run(["ninja", "-C", "build/release", "-k0", f"-j{options.jobs}"], cwd=copy, stdout=log, stderr=log, check=False)
        if done.returncode == 0:
            break
        ids = blamed(copy, mutants, (copy / "build.log").read_text())
        if not ids:
            sys.exit(f"the build failed, and not by a mutant: {copy / 'build.log'}")
        say(f"dropped, since they do not compile: {sorted(ids)}")
        mutants = [m for m in mutants if m["id"] not in ids]
        rewrite(copy, mutants)
        save(copy, facts, mutants)
    say(f"built with {len(mutants)} mutants; the first {min(facts['count'], len(mutants))} of them count")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", choices=["draw", "build"])
    parser.add_argument("--project", type=Path, default=HERE.parents[1])
    parser.add_argument("--copy", type=Path, required=True, help="outside of the project, and without `build` in its path")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--surplus", type=float, default=1.5, help="times as many are drawn at first")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    draw(options) if options.step == "draw" else build(options)


if __name__ == "__main__":
    main()
