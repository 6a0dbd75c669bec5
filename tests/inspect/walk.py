#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A recorded walk, as a new user would: two commands from the files of a receiver and a logger to a filter.

    walk.py BINNACLE DATA

The logger's file has no header, a first line that is cut, forces in g, rates in deg/s, its own clock, and axes of its own. Asked of it: the
filter ends `ok` with the trust limits that come by default, refuses less than 5 %, and the axes are those of the data's README.
Exit status: 0, 1 it is not so, 77 no data.
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

# body (forward, right, down) = Rz(-90 deg) Rx(180 deg) of the sensor, as the data's README has it.
AXES = "forward is -y, right is -x, down is -z"
USER = ["inspect walk.ubx walk_imu.csv.gz --write walk.json", "run walk.json --summary walk_summary.json"]
SCORED = {"extends": "walk.json", "sources": {"truth": {"type": "rtklib_pos", "path": "walk.pos.gz"}},
          "reference": [{"channel": "truth", "blocks": {"ins/position": ["lat", "lon", "height"]}}]}


def run(command, words, folder):
    done = subprocess.run([command] + words.split(), cwd=folder, capture_output=True, text=True)
    print(f"binnacle {words}: exit status {done.returncode}")
    if done.returncode != 0:
        print(done.stderr)
        sys.exit(1)
    return done.stdout


def position(command, folder):
    """Figures only: walk.pos has the receiver's own fixes (equal in each digit), its heights are above the sea."""
    (folder / "scored.json").write_text(json.dumps(SCORED))
    run(command, "run scored.json --summary scored_summary.json", folder)
    errors = json.loads((folder / "scored_summary.json").read_text())["filters"]["ins"]["reference"]
    height = errors["position.height"]
    down = errors["position.down"]["mean"]
    about = max(0.0, height["rms"] ** 2 - down ** 2) ** 0.5
    print(f"position against walk.pos: horizontal {errors['position.horizontal']['rms']:.3f} m rms, height {height['rms']:.3f} m rms: "
          f"{down:.3f} m of it constant, {about:.3f} m rms about that")


def main():
    command, data = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]) / "receivers"
    if not (data / "walk.ubx").is_file():
        print(f"skipped: no recorded walk in {data}")
        return 77
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for name in ("walk.ubx", "walk_imu.csv.gz", "walk.pos.gz"):
            shutil.copy(data / name, folder)
        said = run(command, USER[0], folder)
        run(command, USER[1], folder)
        ins = json.loads((folder / "walk_summary.json").read_text())["filters"]["ins"]
        fix = ins["measurements"]["fix"]
        refused = 1 - fix["accepted"] / fix["offered"]
        print(f"verdict {ins['verdict']['state']}, {fix['accepted']} of {fix['offered']} fixes used, {100 * refused:.2f} % refused")
        position(command, folder)
    checks = {"ends ok": ins["verdict"]["state"] == "ok", "less than 5 % refused": refused < 0.05,
              "axes as in the data's README": AXES in said, "rates and forces have the same axes": "same right-handed axes" in said}
    for what, holds in checks.items():
        print(f"{'ok  ' if holds else 'FAIL'} {what}")
    return 0 if all(checks.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
