#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a live run costs: `tests/bench/live_bench.py [SECONDS]`. Latency at --pace 1 with an IMU of 200 Hz and 21 states, two fixes and
a reference a second; then how many samples a second come through a pipe."""
import json
import os
import subprocess
import sys
import tempfile

BINNACLE = os.path.abspath(os.environ.get("BINNACLE", "build/release/bin/binnacle"))
PROJECT = os.path.abspath(os.environ.get("PROJECT", "."))
SCALES = [f'/filters/ins/blocks/{name}_scale={{"type": "vector", "size": 3, "unit": "1", "sigma": "300 ppm"}}' for name in ("gyro", "accel")]
SCALES += [f'/filters/ins/process/of_{name}_scale={{"type": "random_constant", "blocks": {{"x": "{name}_scale"}}}}' for name in ("gyro", "accel")]
SCALES += [f"/filters/ins/process/strapdown/blocks/{name}_scale={name}_scale" for name in ("gyro", "accel")]


def summary(config, *more, sets=(), **how):
    words = [word for text in sets for word in ("--set", text)]
    done = subprocess.run([BINNACLE, "run", config, "--json", *words, *more], capture_output=True, text=True, **how)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def at_a_pace(seconds):
    drive = f'[{{"do": "still", "duration": "5 s"}}, {{"do": "accelerate", "to": "10 m/s", "acceleration": "1 m/s^2"}}, {{"do": "straight", "duration": "{max(1, seconds - 15)} s"}}]'
    sets = [f"/sources/drive/segments={drive}", '/sources/drive/imu_rate="200 Hz"', "/evaluate=null", *SCALES]
    figures = summary(f"{PROJECT}/configs/quickstart.json", "--pace", "1", sets=sets)
    for name, channel in figures["live"]["channels"].items():
        print(f"--pace 1, {name:12} {channel['samples']:7} samples: p50 {1e3 * channel['latency_p50_s']:.3f} ms, "
              f"p99 {1e3 * channel['latency_p99_s']:.3f} ms, max {1e3 * channel['latency_max_s']:.3f} ms")


def as_fast_as_it_goes():
    subprocess.run([BINNACLE, "run", f"{PROJECT}/configs/tutorial/data.json", "--var", "folder=.", "--quiet"], check=True)
    with open("imu.csv") as imu:
        live = summary(f"{PROJECT}/configs/live/drive.json", "--var", "data=.", stdin=imu)["live"]
    samples = sum(channel["samples"] for channel in live["channels"].values())
    lost = sum(source["lost"] for source in live["sources"].values())
    print(f"stream/csv from a file as standard input: {samples / live['seconds']:.0f} samples a second, {lost} lost")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        at_a_pace(int(sys.argv[1]) if len(sys.argv) > 1 else 60)
        as_fast_as_it_goes()
        os.chdir("/")


if __name__ == "__main__":
    main()
