#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plants faults into recorded drives and scores what `binnacle inspect` says of them.

    planted.py BINNACLE DATA [--sample N/M] [--drive WORD] [--fault WORD] [--jobs N] [--table FILE] [--keep FOLDER] [--held-out]

A cell (fault, drive) passes where a finding names kind, channel, field and value, and no other warning and no wrong remedy stands beside it;
where the data not determined, a pass is "not determined" too, in the cells of undetermined.json only. Exit status: 0, 1 a cell failed, 77 no data.
"""

import argparse
import concurrent.futures
import csv
import gzip
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import faults
from faults import FAULTS, Drive

HERE = pathlib.Path(__file__).resolve().parent
DRIVES = {"parkinglot": "parkinglot-maneuvers", "medium-turn-loop": "urban-medium-turn-loop-nominal-001",
          "long-drive-large-mount": "mixed-road-long-drive-large-mount-001"}
# A drive whose planted faults nobody had looked at when the program was changed last.
HELD_OUT = {"stop-go-large-mount": "urban-stop-go-large-mount-001"}
# Roll, pitch, yaw [deg] of the data's README: C = Rz Ry Rx turns the sensor's axes into forward, left, up.
MOUNT = {"parkinglot": (-1.82, -24.60, 96.87), "medium-turn-loop": (-1.17, -0.02, 2.59),
         "long-drive-large-mount": (170.79, 60.50, 167.45), "stop-go-large-mount": (170.75, 60.59, 168.91)}


def rows_of(path):
    with gzip.open(path, "rt") as file:
        rows = list(csv.reader(file))
    return rows[0], rows[1:]


def load(folder, name):
    headers = {}
    headers["imu"], imu = rows_of(folder / "imu.csv.gz")
    headers["gnss"], gnss = rows_of(folder / "gnss.csv.gz")
    _, attitude = rows_of(folder / "reference_attitude.csv.gz")
    track = [(float(row[0]), math.radians(float(row[3]))) for row in attitude if any(float(cell) for cell in row[1:])]
    seen = {"at": 0}

    def yaw(t):
        i = seen["at"]
        while i + 1 < len(track) and track[i + 1][0] < t:
            i += 1
        while i > 0 and track[i][0] > t:
            i -= 1
        seen["at"] = i
        if t <= track[0][0] or i + 1 >= len(track):
            return track[i][1]
        share = (t - track[i][0]) / (track[i + 1][0] - track[i][0])
        return track[i][1] + share * math.remainder(track[i + 1][1] - track[i][1], 2 * math.pi)

    return headers, Drive(name, imu, gnss, yaw)


def write(path, header, rows):
    with open(path, "w") as file:
        file.write(",".join(header) + "\n")
        file.writelines(",".join(row) + "\n" for row in rows)


def inspect(command, headers, drive, folder):
    for channel in ("imu", "gnss"):
        write(folder / f"{channel}.csv", headers[channel], getattr(drive, channel))
    done = subprocess.run([command, "inspect", str(folder / "imu.csv"), str(folder / "gnss.csv"), "--json"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        return None, f"exit status {done.returncode}: {done.stderr.strip()[:200]}"
    return json.loads(done.stdout), ""


def fields_of(finding):
    return {field.strip() for field in finding["field"].split(",") if field.strip()}


def before(kind, field, clean):
    """What the clean drive has of it: its receiver's own latency, its own lever arm."""
    return next((each["value"] for each in clean["report"]["findings"] if each["kind"] == kind and each["field"] == field), 0)


def is_remedy(patch, fault, clean):
    """Whether this change of the config undoes the fault."""
    if patch is None or patch in fault.remedies:
        return True
    for each in fault.remedies:
        if each == "mirror" and is_mirror(patch):
            return True
        if each == "interval" and list(patch["sources"].get("imu", {})) == ["interval"]:
            return True
        if each == "heading" and is_heading(patch, fault):
            return True
        if isinstance(each, tuple) and is_offset(patch, each, before("delay", "", clean)):
            return True
    return False


def is_offset(patch, wanted, own):
    """The clock of one channel, by so much: of GNSS by `offset`, or of the IMU by its opposite."""
    for channel, sign in (("gnss", 1), ("imu", -1)):
        time = patch["sources"].get(channel, {}).get("time", {})
        if list(time) == ["offset"] and list(patch["sources"]) == [channel]:
            return abs(sign * float(time["offset"].split()[0]) + own - wanted[1]) <= wanted[2]
    return False


def is_mirror(patch):
    """One reflection, of rates and forces alike."""
    change = patch["sources"]["imu"]["columns"]
    letters = [{key[1]: value for key, value in change.items() if key[0] == letter} for letter in "wf"]
    if set(letters[0]) != set(letters[1]) or not letters[0]:
        return False
    signs = 1
    for axis, value in letters[0].items():
        column = value.get("column")
        source = next((field[1] for field, at in faults.COLUMN.items() if faults.NAME.get(at) == column), axis)
        other = letters[1][axis].get("column")
        if column and next(field[1] for field, at in faults.COLUMN.items() if faults.NAME.get(at) == other) != source:
            return False
        if value.get("scale", 1) != letters[1][axis].get("scale", 1):
            return False
        signs *= value.get("scale", 1)
    exchanged = sum("column" in value for value in letters[0].values())
    return (exchanged == 0 and signs == -1) or (exchanged == 2 and signs == 1)


def is_heading(patch, fault):
    change = patch["sources"]["gnss"]["columns"].get("yaw", {})
    offset = math.radians(float(str(change.get("offset", "0")).split()[0]))
    scale = change.get("scale", 1)
    turned = {"heading_sense": math.pi / 2 - 0.3, "heading_offset": 0.3 + math.pi / 2}[fault.kinds[0]]
    return abs(math.remainder(scale * turned + offset - 0.3, 2 * math.pi)) < math.radians(2)


def has_value(finding, fault, drive, clean):
    if fault.value is None:
        if fault.kinds == ["velocity_fault"]:
            return abs(finding["evidence"]["from_s"] + clean["begin"]["gnss"] - drive.begin) < 6
        return finding["value"] is not None
    value = fault.value(drive) if callable(fault.value) else fault.value
    found = finding["value"]
    if found is None:
        return False
    if fault.shift:
        found -= before(finding["kind"], finding["field"], clean)
    if fault.within == "size":
        return abs(abs(found) - value) < 1e-6 + 1e-6 * abs(value)
    return abs(found - value) <= fault.within * (1 if fault.absolute else abs(value)) + 1e-12


def judge(report, fault, drive, clean):
    """("pass" | "not determined" | "wrong remedy" | "missed" | "false alarm", what it is by)."""
    matching, others, wrong = [], [], []
    named = set()
    for finding in report["findings"]:
        its = finding["kind"] in fault.kinds and finding["channel"] == fault.channel
        if finding["severity"] == "warning" and not is_remedy(finding["meaning"], fault, clean):
            wrong.append(finding)
        if its and finding["severity"] == fault.severity and fields_of(finding) <= fault.fields \
                and has_value(finding, fault, drive, clean):
            matching.append(finding)
            named |= fields_of(finding)
        elif finding["severity"] == "warning" and finding["kind"] not in fault.also and finding["kind"] != "overlap":
            others.append(finding)
    if wrong:
        return "wrong remedy", wrong[0]
    if matching and named == fault.fields:
        return ("false alarm", others[0]) if others else ("pass", matching[0])
    if others:
        return "missed", others[0]
    unknown = [finding for finding in report["findings"] if finding["severity"] == "unknown"]
    return ("not determined" if unknown else "missed"), (unknown[0] if unknown else None)


def mount_error(report, name):
    """Angle [deg] between the mounting found and that of the data's README."""
    if "mounting" not in report:
        return None
    roll, pitch, yaw = (math.radians(angle) for angle in MOUNT[name])
    cr, sr, cp, sp, cy, sy = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch), math.cos(yaw), math.sin(yaw)
    flu = [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
           [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], [-sp, cp * sr, cp * cr]]
    frd = [flu[0], [-x for x in flu[1]], [-x for x in flu[2]]]
    trace = sum(frd[i][k] * report["mounting"][i][k] for i in range(3) for k in range(3))
    return math.degrees(math.acos(max(-1, min(1, (trace - 1) / 2))))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--sample", default="1/1", help="N/M: each Mth cell from the Nth on")
    parser.add_argument("--drive", default="")
    parser.add_argument("--fault", default="")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--table")
    parser.add_argument("--held-out", action="store_true", help="the drive that was held out, in place of the three")
    parser.add_argument("--keep", help="files and report of each cell stay here")
    return parser


def listed_cells():
    """Cells that the data do not determine, as committed before the first scoring."""
    undetermined = {(cell["fault"], drive) for cell in json.loads((HERE / "undetermined.json").read_text())
                    for drive in cell["drives"]}
    unknown = {cell for cell in undetermined if cell[0] not in {fault.name for fault in FAULTS}}
    assert not unknown, f"undetermined.json names faults that are not there: {unknown}"
    assert 10 * len(undetermined) <= len(FAULTS) * len(DRIVES), "more than a tenth of the cells are listed as undetermined"
    return undetermined


def table_of(results):
    names = [name for name in DRIVES | HELD_OUT if any(key[0] == name for key in results)]
    table = "| fault | " + " | ".join(names) + " |\n|---|" + "---|" * len(names) + "\n"
    for fault in ["clean"] + [each.name for each in FAULTS]:
        row = [results.get((name, fault), "") for name in names]
        if any(row):
            table += f"| {fault} | " + " | ".join(row) + " |\n"
    return table


def main():
    options = arguments().parse_args()
    if not (options.data / "drives").is_dir():
        print(f"skipped: no recorded drives in {options.data}")
        return 77
    undetermined = listed_cells()
    first, every = (int(part) for part in options.sample.split("/"))
    results, failed = {}, []
    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for d, (name, folder) in enumerate((HELD_OUT if options.held_out else DRIVES).items()):
            if options.drive not in name:
                continue
            headers, drive = load(options.data / "drives" / folder, name)
            place = pathlib.Path(options.keep or temporary)
            own = place / f"{name} clean"
            own.mkdir(parents=True, exist_ok=True)
            report, fault_text = inspect(options.command, headers, drive, own)
            warnings = [f["kind"] + " " + f["field"] for f in report["findings"] if f["severity"] == "warning"]
            error = mount_error(report, name)
            good = not warnings and error is not None and error <= 3
            print(f"{'ok  ' if good else 'FAIL'} {name}: clean: warnings {warnings}, mounting off by {error} deg", flush=True)
            if not good:
                failed.append((name, "clean"))
            results[name, "clean"] = f"no warning; mounting off by {error:.1f} deg" if good else "FAIL"
            clean = {"report": report, "begin": {c: float(getattr(drive, c)[0][0]) for c in ("imu", "gnss")}}

            def cell(n, fault):
                planted = drive.copy()
                fault.plant(planted)
                its = place / f"{name} {n}"
                its.mkdir(parents=True, exist_ok=True)
                report, text = inspect(options.command, headers, planted, its)
                if options.keep:
                    (its / "report.json").write_text(json.dumps(report, indent=1))
                else:
                    for file in its.iterdir():
                        file.unlink()
                return (judge(report, fault, planted, clean)) if report else ("missed", {"kind": text, "field": "", "text": ""})

            chosen = [(n, fault) for n, fault in enumerate(FAULTS)
                      if options.fault in fault.name and (n + d) % every == first % every]
            for (n, fault), (verdict, by) in zip(chosen, pool.map(lambda each: cell(*each), chosen)):
                listed = (fault.name, name) in undetermined
                good = verdict == "pass" or (verdict == "not determined" and listed)
                if not good:
                    failed.append((name, fault.name))
                results[name, fault.name] = verdict if good else f"**{verdict}**"
                text = f"{by['kind']} {by['field']}: {by['text']}" if by else ""
                print(f"{'ok  ' if good else 'FAIL'} {name} [{n}] {fault.name}: {verdict}; {text}", flush=True)
    table = table_of(results)
    counts = {}
    for key, verdict in results.items():
        if key[1] != "clean":
            counts[verdict] = counts.get(verdict, 0) + 1
    summary = f"{sum(counts.values())} cells: " + ", ".join(f"{n} {v}" for v, n in sorted(counts.items()))
    print(summary)
    if options.table:
        pathlib.Path(options.table).write_text(table + "\n" + summary + "\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
