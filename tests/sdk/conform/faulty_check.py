#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""faulty_check.py SUITE {--types | --registration | --whole} LIBRARY SOURCE… [--instead NAME EXPECTED]…

Each fault is found by the check that the head of its source names, with the status that it names (fail, where it names none), and
nothing else about it is bad: `// fails: CHECK [STATUS[/STATUS]]`. CHECK "nothing": nothing at all. CHECK "verdict": nothing is bad,
and yet it does not conform, for none of the checks of numbers could be tried.

--types         the library's types are the faults, one or more (`// types: …`) of each source; it has no other
--registration  the library is healthy, and copies of it are the faults: those of the sources, and the alterations below
--whole         the library is the fault, of one source

--instead NAME EXPECTED: what is expected of a fault in this build. Prints a line for each fault; exit status 1: one is not as expected.
"""
import argparse
import json
import re
import struct
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

BAD = {"fail", "crash", "timeout"}


@dataclass
class Fault:
    name: str
    types: list
    check: str
    statuses: set

    @property
    def is_good(self):
        return self.check == "nothing" or (self.check != "verdict" and not self.statuses & BAD)


def fault_of(name, expected, types=()):
    check, *status = expected.split()
    return Fault(name, list(types) or [name], check, set("".join(status or ["fail"]).split("/")))


def faults_in(sources, instead):
    faults = []
    for source in map(Path, sources):
        head = re.findall(r"^// (fails|types): (.+)$", source.read_text(), re.MULTILINE)
        (expected,) = [text for key, text in head if key == "fails"]
        faults.append(fault_of(source.stem, instead.pop(source.stem, expected), " ".join(t for key, t in head if key == "types").split()))
    if instead:
        sys.exit(f"there is no fault {', '.join(instead)}")
    return faults


class Run:
    """The suite on a library, or on some of its types; the type "" is the library itself."""

    def __init__(self, suite, library, types=()):
        only = [word for name in types for word in ("--only", f"{name}:*")]
        command = [suite, library, "--json", "-", "--jobs", "1", "--time-limit", "10", "--level", "5", *only]
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        try:
            self.results = json.loads(done.stdout)
        except ValueError:
            sys.exit(f"no JSON but: {done.stdout}{done.stderr}")
        self.checks = self.results["checks"]
        self.status = done.returncode

    def wrong_verdict(self, is_good):
        conforms = self.results["conforms"]
        return [] if conforms == is_good and self.status == (0 if is_good else 1) else [f"the verdict is wrong: {conforms}, status {self.status}"]


def judge(fault, checks):
    """What the suite found, as a line, and what is wrong with that."""
    found = "" if fault.check not in ("nothing", "verdict") else f"{fault.check}, {len(checks)} checks"
    wrong = [] if checks else ["it was not examined"]
    for check in checks:
        name, status, message = check["check"], check["status"], check["message"].replace("\n", " | ")
        if name == fault.check and status in fault.statuses:
            found = f"{name} is {status}: {message}"
        elif status not in ("pass", "skip") and not (fault.check == "verdict" and status == "warn"):
            wrong.append(f"besides, {name} is {status}: {message}")
    if not found:
        wrong.append(f"{fault.check} is not {'/'.join(sorted(fault.statuses))}")
    return found, wrong


class Printer:
    def __init__(self):
        self.count = self.failed = 0

    def print(self, name, found, wrong):
        self.count += 1
        self.note(f"{name:24} {found[:200]}", wrong)

    def note(self, text, wrong):
        self.failed += bool(wrong)
        print(text, *(f"  WRONG: {text}" for text in wrong), sep="\n", flush=True)

    def end(self):
        print(f"{self.count} faults, {self.failed} not as expected")
        return 1 if self.failed or self.count == 0 else 0


def group_of(fault):
    """What the verdict rests on, so that each kind stands for itself."""
    if fault.is_good:
        return "good"
    if fault.check == "verdict":
        return "verdict"
    is_early = fault.check.startswith(("metadata.", "life."))  # what numbers wait for
    return ("early " if is_early else "") + "/".join(sorted(fault.statuses))


def wrong_of_group(group, names, run, components):
    wrong = run.wrong_verdict(group == "good")
    wrong += judge(fault_of("library", "nothing"), [check for check in run.checks if not check["component"]])[1]
    wrong += [f"{check['component']} was examined" for check in run.checks if check["component"] not in {"", *names}]
    untried = set(run.results["untried"])
    if untried - names.keys() if group.startswith("early") else untried != (names.keys() if group == "verdict" else set()):
        wrong.append(f"untried are {sorted(untried)}")
    if run.results["components"] != components or run.results["enumeration"]:
        wrong.append(f"it has {run.results['components']} components, not {components}. {run.results['enumeration']}")
    return wrong


def check_types(suite, library, faults, printer):
    groups = {}
    for fault in faults:
        groups.setdefault(group_of(fault), []).append(fault)
    order = sorted(groups, key=lambda group: ("timeout" not in group, group))  # those wait longest
    names_of = {group: {f"faulty/{kind}": fault for fault in groups[group] for kind in fault.types} for group in order}
    components = sum(map(len, names_of.values()))
    run_of = lambda group: Run(suite, library, [*names_of[group], *([""] if group == "good" else [])])
    with ThreadPoolExecutor(2) as pool:
        for group, run in zip(order, pool.map(run_of, order)):
            for fault in groups[group]:
                judged = [judge(fault, [check for check in run.checks if check["component"] == f"faulty/{kind}"]) for kind in fault.types]
                printer.print(fault.name, judged[0][0], [text for _, wrong in judged for text in wrong])
            printer.note(f"verdict on {group}", wrong_of_group(group, names_of[group], run, components))


def check_whole(suite, library, fault, printer):
    run = Run(suite, library)
    found, wrong = judge(fault, run.checks)
    is_good = not any(check["status"] in BAD for check in run.checks) and fault.check != "verdict"
    printer.print(fault.name, found, wrong + run.wrong_verdict(is_good))


class Image:
    """A library's bytes: 64-bit little-endian ELF."""

    # binnacle::abi::Guard, bytes from its start
    SIZE, API_MAJOR, SIZE_OF_4TH_TYPE, INSTRUCTION_SETS, VERSION, END = 8, 12, 24 + 3 * 8, 824, 968, 1000

    def __init__(self, library):
        self.data = bytearray(library.read_bytes())
        self.guard = self.only(b"BINNACLE" + struct.pack("<I", self.END))
        if self.data[self.guard + self.VERSION:self.guard + self.END] != b"1.0.0".ljust(32, b"\0"):
            sys.exit("the guard is laid out otherwise")

    def only(self, text):
        if self.data.count(text) != 1:
            sys.exit(f"{text} is there {self.data.count(text)} times")
        return self.data.index(text)

    def change(self, place, form, value_of):
        """The number at a place of the guard."""
        (value,) = struct.unpack_from("<" + form, self.data, self.guard + place)
        struct.pack_into("<" + form, self.data, self.guard + place, value_of(value))

    def set_text(self, start, text, room):
        at = self.only(start)
        self.data[at:at + room] = text.ljust(room, b"\0")

    def register(self, name, listed=b""):
        self.set_text(b"registers:all", b"registers:" + name.encode(), 48)
        self.set_text(b"process measurement derived", listed, len(b"process measurement derived block noise source transform"))

    def set_version(self, text):
        self.data[self.guard + self.VERSION:self.guard + self.END] = text.ljust(32, b"\0")

    def hide_guard(self):
        self.data = self.data.replace(b"binnacle_guard_v1", b"no_binnacle_guard")

    def pin(self):
        """As -z nodelete of the linker does: DF_1_NODELETE in DT_FLAGS_1 of the dynamic segment."""
        heads, size, count = struct.unpack_from("<Q14xHH", self.data, 32)
        for head in range(heads, heads + size * count, size):
            kind, _, at = struct.unpack_from("<IIQ", self.data, head)
            while kind == 2:
                tag, value = struct.unpack_from("<qQ", self.data, at)
                if tag == 0x6ffffffb:
                    return struct.pack_into("<Q", self.data, at + 8, value | 8)
                if tag == 0:
                    break
                at += 16
        sys.exit("its dynamic segment has no flags: link it with -z now")


def only_process(image, listed=b""):
    image.register("process", listed)
    return image


# Name, what is expected, a word of the message, alteration.
ALTERATIONS = [
    ("healthy", "nothing", "", lambda image: None),  # breaks no rule: the control
    ("no_guard", "load.guard", "exports no binnacle_guard_v1", Image.hide_guard),
    ("cut_guard", "load.guard", "size of the guard", lambda image: image.change(Image.SIZE, "I", lambda size: size - 4)),
    ("older_api", "load.guard", "API major", lambda image: image.change(Image.API_MAJOR, "I", lambda _: 0)),
    ("other_layout", "load.guard", "ParameterSpec", lambda image: image.change(Image.SIZE_OF_4TH_TYPE, "I", lambda size: size + 8)),
    ("other_processor", "load.guard", "this processor lacks bit 60", lambda image: image.change(Image.INSTRUCTION_SETS, "Q", lambda bits: bits | 1 << 60)),
    ("odd_version", "metadata.version", "newest", lambda image: only_process(image).set_version(b"newest")),
    # It lists a type that it does not register, and lacks the one that it does.
    ("wrong_list", "load.register", "lists 'nothing'", lambda image: only_process(image, b"nothing")),
    ("pinned", "load.cycle", "stays in memory", lambda image: only_process(image).pin()),  # stays there for ever
]


def check_registration(suite, library, faults, printer):
    copies = [(fault_of(name, expected), words, alter) for name, expected, words, alter in ALTERATIONS]
    copies += [(fault, "", lambda image, name=fault.name: image.register(name)) for fault in faults]
    with tempfile.TemporaryDirectory(dir=library.parent) as scratch, ThreadPoolExecutor(2) as pool:

        def run_on_copy(fault, _, alter):
            image = Image(library)
            alter(image)
            copy = Path(scratch) / f"{fault.name}.so"
            copy.write_bytes(image.data)
            copy.chmod(0o755)
            return Run(suite, copy)

        for (fault, words, _), run in zip(copies, pool.map(lambda copy: run_on_copy(*copy), copies)):
            found, wrong = judge(fault, run.checks)
            if words not in found:
                wrong.append(f"that does not say '{words}'")
            printer.print(fault.name, found, wrong + run.wrong_verdict(fault.is_good))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("suite", type=Path)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--types", type=Path)
    what.add_argument("--registration", type=Path)
    what.add_argument("--whole", type=Path)
    parser.add_argument("--instead", nargs=2, action="append", default=[])
    parser.add_argument("sources", nargs="+")
    arguments = parser.parse_args()
    faults, printer = faults_in(arguments.sources, dict(arguments.instead)), Printer()
    if arguments.types:
        check_types(arguments.suite, arguments.types, faults, printer)
    elif arguments.registration:
        check_registration(arguments.suite, arguments.registration, faults, printer)
    else:
        (fault,) = faults
        check_whole(arguments.suite, arguments.whole, fault, printer)
    return printer.end()


if __name__ == "__main__":
    sys.exit(main())
