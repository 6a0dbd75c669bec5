#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the tests on the mutants that draw.py built: run.py --copy FOLDER [--jobs N] [--minutes M]

FOLDER/baseline.jsonl  each test without a mutant: time, and the mutants that it reaches
FOLDER/events.jsonl    each run with mutants; run.py, started again, goes on from there
FOLDER/results.jsonl, FOLDER/summary.txt  the outcome. README.md says how it is decided.
"""
import argparse
import collections
import concurrent.futures
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
from draw import load, say  # noqa: E402

# They read sources, install, build, or count instructions: they see the switches of mutants, or no mutant.
LEFT_OUT = re.compile(r"^(structure|package|dist|bench|site|skipping|compare|elsewhere): |^docs: sdk/run|^fuzz: archives")
ALONE_SECONDS = 8  # of the quick tests, cheapest first, on each mutant alone; what survives is tried in groups
SHORTEST_LIMIT = 30
MOST_MEMORY = 8 << 30
BROWSER = re.compile(r"^(report|page): ")  # reserves more
FAILED = ("fail", "timeout")


class Item:
    """A case of an executable, or a test of ctest that is not made of cases."""
    outcome, cpu, limit, reached = "", 0.0, 0.0, frozenset()

    def __init__(self, test, case=None):
        self.all = {p["name"]: p["value"] for p in test["properties"]}
        self.name = f"{test['name']}: {case}" if case else test["name"]
        self.command = [test["command"][0], re.sub(r'([\\,\["*~])', r"\\\1", case), "--warn", "NoTests"] if case else test["command"]
        self.is_quick = "quick" in self.all.get("LABELS", [])
        self.environment = dict(e.split("=", 1) for e in self.all.get("ENVIRONMENT", []) if not e.startswith("BINNACLE_JUNIT="))
        self.locks = self.all.get("RESOURCE_LOCK", []) + ([] if case else [self.name])


def items_of(build):
    said = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, text=True, check=True).stdout
    executables = [line.split(" ", 1)[1] for line in (build / "tests/executables.txt").read_text().splitlines()]
    for test in (test for test in json.loads(said)["tests"] if not LEFT_OUT.match(test["name"])):
        cases = [None]
        if test["command"][0] in executables:
            words = [w for w in test["command"] if w not in ("--warn", "NoTests")] + ["--list-test-names-only"]
            cases = subprocess.run(words, capture_output=True, text=True, check=False).stdout.splitlines()
        yield from (Item(test, case and case.strip()) for case in cases)


locks = collections.defaultdict(threading.Lock)


def execute(item, mutants, limit):
    """(pass, fail, skip or timeout; processor seconds; numbers of the mutants that were reached)."""
    held = [locks[name] for name in sorted(item.locks)]
    scratch = Path(tempfile.mkdtemp(prefix="bm"))
    (scratch / "tmp").mkdir()
    environment = {**os.environ, **item.environment, "TMPDIR": str(scratch / "tmp"), "BINNACLE_REACHED": str(scratch / "reached"),
                   "BINNACLE_MUTANT": ",".join(map(str, mutants))}

    def limited():
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a job in a shell's background ignores it, and so would the test
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if not BROWSER.match(item.name):
            resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))

    for lock in held:
        lock.acquire()
    with open(scratch / "out", "w+b") as out:
        process = subprocess.Popen(item.command, cwd=item.all["WORKING_DIRECTORY"], env=environment, stdin=subprocess.DEVNULL,
                                   stdout=out, stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=limited)
        end, pause, pid = time.monotonic() + limit, 0.002, 0
        while not pid and time.monotonic() < end:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            time.sleep(0 if pid else pause)
            pause = min(0.05, 1.5 * pause)
        try:
            os.killpg(process.pid, signal.SIGKILL)  # with whatever it left behind
        except ProcessLookupError:
            pass
        if not pid:
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        said = out.read(4 << 20).decode("utf-8", "replace")
    for lock in held:
        lock.release()
    matching = item.all.get("PASS_REGULAR_EXPRESSION")
    passed = any(re.search(p, said) for p in matching) if matching else (process.returncode == 0) != item.all.get("WILL_FAIL", False)
    outcome = "timeout" if not pid else "skip" if process.returncode == item.all.get("SKIP_RETURN_CODE") else "pass" if passed else "fail"
    reached = {int(n) for n in (scratch / "reached").read_text().split()} if (scratch / "reached").exists() else set()
    shutil.rmtree(scratch, ignore_errors=True)
    return outcome, round(usage.ru_utime + usage.ru_stime, 3), reached


def lines_of(file):
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []


class Work:
    def __init__(self, options):
        self.copy, self.jobs, self.mutex = options.copy.resolve(), options.jobs, threading.Lock()
        self.end = time.monotonic() + 60 * options.minutes
        self.facts, mutants = load(self.copy)
        self.mutants = mutants[:self.facts["count"]]
        self.killed, self.tried, self.flaky = {}, collections.defaultdict(set), set()  # number: (item, outcome); number: items
        self.items = self.baseline()
        for event in lines_of(self.copy / "events.jsonl"):
            self.take(event)

    def say(self, text):
        say(f"{time.strftime('%H:%M:%S')} {text}")

    def each(self, call, things):
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            list(pool.map(call, things))

    def append(self, name, line):
        with self.mutex, (self.copy / name).open("a", encoding="utf-8") as out:
            out.write(json.dumps(line) + "\n")

    def baseline(self):
        """The tests that pass without a mutant and reach one; the cheapest first."""
        known, items = {e["name"]: e for e in lines_of(self.copy / "baseline.jsonl")}, list(items_of(self.copy / "build/release"))

        def run(item):
            if item.name not in known:
                begin = time.monotonic()
                outcome, cpu, reached = execute(item, [], float(item.all.get("TIMEOUT", 600)))
                known[item.name] = {"name": item.name, "quick": item.is_quick, "outcome": outcome, "cpu": cpu,
                                    "wall": round(time.monotonic() - begin, 3), "reached": sorted(reached)}
                self.append("baseline.jsonl", known[item.name])
            fact = known[item.name]
            item.outcome, item.cpu, item.limit = fact["outcome"], fact["cpu"], max(SHORTEST_LIMIT, 10 * fact["wall"])
            item.reached = {m["id"] for m in self.mutants} & set(fact["reached"])

        self.each(run, items)
        self.say(f"without a mutant: {dict(collections.Counter(i.outcome for i in items))}; {sum(i.cpu for i in items if i.is_quick):.0f} s of "
                 f"{sum(i.cpu for i in items):.0f} s are quick; these fail and are left out: {[i.name for i in items if i.outcome in FAILED]}")
        return sorted((i for i in items if i.outcome == "pass" and i.reached), key=lambda i: i.cpu)

    def take(self, event):
        for number in event["mutants"]:
            self.tried[number].add(event["item"])
            if event["outcome"] in FAILED:
                self.killed[number] = event["item"], event["outcome"]
        if event["outcome"] == "flaky":
            self.flaky.add(event["item"])

    def run_with(self, item, numbers):
        """Outcome and reached mutants. A single mutant is killed if the test fails a second time, too."""
        outcome, cpu, reached = execute(item, numbers, item.limit)
        if len(numbers) == 1 and outcome == "fail" and execute(item, numbers, item.limit)[0] not in FAILED:
            outcome = "flaky"
        done = numbers if len(numbers) == 1 else [n for n in numbers if n in reached] if outcome not in FAILED else []
        event = {"mutants": done, "item": item.name, "outcome": outcome, "cpu": cpu}
        self.append("events.jsonl", event)
        self.take(event)
        if done and outcome in FAILED:
            self.say(f"{len(self.killed)} killed: {numbers[0]} by {item.name} ({outcome})")
        return outcome, [n for n in numbers if n not in done]

    def group(self, item, numbers):
        """Several mutants at once on one test; if it fails, each half of them, down to single ones. Whether one was killed."""
        if time.monotonic() > self.end:
            return True
        outcome, left = self.run_with(item, numbers)
        if len(numbers) == 1:
            return outcome in FAILED
        if outcome not in FAILED:  # left are those from which another one keeps the test away
            return any([self.group(item, [n]) for n in left])
        half = len(numbers) // 2
        if any([self.group(item, numbers[:half]), self.group(item, numbers[half:])]):
            return True
        self.say(f"{numbers} fail {item.name} together, and no half of them does")
        return any([self.group(item, [n]) for n in numbers if item.name not in self.tried[n]])

    def alone(self, mutant):
        """The quick tests on one mutant, those first that are cheap and reach few others, until one fails."""
        number, spent = mutant["id"], 0.0
        items = [i for i in self.items if i.is_quick and number in i.reached and i.cpu < ALONE_SECONDS]
        for item in sorted(items, key=lambda i: (0.05 + i.cpu) * len(i.reached)):
            spent += 0.05 + item.cpu
            if number in self.killed or spent > ALONE_SECONDS or time.monotonic() > self.end:
                break
            if item.name not in self.tried[number] | self.flaky:
                self.run_with(item, [number])

    def by_groups(self, item):
        numbers = [n for n in sorted(item.reached) if n not in self.killed and item.name not in self.tried[n]]
        if numbers and item.name not in self.flaky:
            self.group(item, numbers)

    def run(self):
        self.each(self.alone, self.mutants)
        self.say(f"{len(self.killed)} of {len(self.mutants)} killed by quick tests on each alone")
        self.each(self.by_groups, [i for i in self.items if i.is_quick])
        self.say(f"{len(self.killed)} killed by quick tests")
        self.each(self.by_groups, [i for i in self.items if not i.is_quick])
        results, quick = [], {i.name for i in self.items if i.is_quick}
        for mutant in self.mutants:
            number = mutant["id"]
            reaching = [i.name for i in self.items if number in i.reached and i.name not in self.flaky]
            by, how = self.killed.get(number, (None, None))
            results.append({**{key: mutant[key] for key in mutant if key not in ("edits", "lines")}, "reached_by": len(reaching),
                            "reached_by_quick": len(quick & set(reaching)), "killed_by": by, "how": how,
                            "tier": by and ("quick" if by in quick else "all"), "not_run": 0 if by else len(set(reaching) - self.tried[number])})
        (self.copy / "results.jsonl").write_text("".join(json.dumps(r) + "\n" for r in results), encoding="utf-8")
        (self.copy / "summary.txt").write_text(self.summary(results), encoding="utf-8")
        print(self.summary(results))

    def summary(self, results):
        tiers = {tier: [r for r in results if r["tier"] == tier] for tier in ("quick", "all", None)}
        quick, everything, none = len(tiers["quick"]), len(tiers["quick"]) + len(tiers["all"]), tiers[None]
        kinds = ", ".join(f"{n} {kind}" for kind, n in sorted(collections.Counter(r["kind"] for r in results).items()))
        lines = [f"seed {self.facts['seed']}, commit {self.facts['commit']}: {len(results)} mutants ({kinds})",
                 f"killed by the quick set {quick}, by all {everything}: {100 * quick / max(1, everything):.1f} %",
                 f"killed by neither {len(none)}; of these {sum(not r['reached_by'] for r in none)} are reached by no test, and on "
                 f"{sum(r['not_run'] > 0 for r in none)} not every test was run",
                 f"tests that failed once and not again: {', '.join(sorted(self.flaky)) or 'none'}"]
        for title, tier in (("killed by all and not by the quick set", "all"), ("killed by neither", None)):
            lines += ["", f"{title}:"]
            for r in tiers[tier]:
                lines += [f"{r['file']}:{r['line']} {r['kind']} [{r['at']}], mutant {r['id']}, {r['reached_by']} tests reach it, {r['reached_by_quick']} of "
                          f"them quick, {r['not_run']} not run" + (f"; killed by {r['killed_by']}" if tier else ""),
                          f"    {r['original'][:160]}", f"    {r['mutated'][:160]}"]
        return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--copy", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--minutes", type=float, default=600, help="no test begins after them")
    Work(parser.parse_args()).run()


if __name__ == "__main__":
    main()
