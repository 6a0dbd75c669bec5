# SPDX-License-Identifier: Apache-2.0
"""A receiver at two pseudo-terminals: a recorded drive's NMEA and IMU go in as they would live; gpsd reads the NMEA that comes out."""
import csv
import gzip
import json
import math
import os
import pty
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import termios
import threading
import time
import tty

BINNACLE, PROJECT = os.environ["BINNACLE"], os.environ["PROJECT"]
DATA = os.environ.get("BINNACLE_DATA") or f"{PROJECT}/../shared/data"
DRIVE = f"{DATA}/drives/urban-medium-turn-loop-nominal-001"
GPSD = next((path for path in ("/usr/sbin/gpsd", "/usr/local/sbin/gpsd", "/usr/bin/gpsd") if os.path.exists(path)), None)
EPOCH, EPOCH_SECONDS = "2026-11-23T12:00:00Z", 12 * 3600
LENGTH = 120.0  # of the drive [s]
SKIPPED = 77


def rows(name):
    with gzip.open(f"{DRIVE}/{name}.csv.gz", "rt") as file:
        for row in csv.DictReader(file):
            values = {key: float(value) for key, value in row.items()}
            if 0 <= values["t_s"] < LENGTH:
                yield values


def sentence(body):
    checksum = 0
    for byte in body.encode():
        checksum ^= byte
    return f"${body}*{checksum:02X}\r\n"


def angle(degrees, width, signs):
    whole = int(abs(degrees))
    return f"{whole:0{width}d}{(abs(degrees) - whole) * 60:010.7f},{signs[degrees < 0]}"


def of_receiver(fix):
    """GGA and RMC of one epoch; the height above the sea is that above the ellipsoid, so the geoid is at 0."""
    t = fix["t_s"] + EPOCH_SECONDS
    clock = f"{int(t // 3600):02d}{int(t // 60 % 60):02d}{t % 60:06.3f}"
    place = f"{angle(fix['lat_deg'], 2, 'NS')},{angle(fix['lon_deg'], 3, 'EW')}"
    speed = math.hypot(fix["vn_mps"], fix["ve_mps"]) * 3600 / 1852
    course = math.degrees(math.atan2(fix["ve_mps"], fix["vn_mps"])) % 360
    return (sentence(f"GNGGA,{clock},{place},1,12,0.8,{fix['height_m']:.3f},M,0.0,M,,")
            + sentence(f"GNRMC,{clock},A,{place},{speed:.3f},{course:.3f},231126,,,A"))


def config(imu, gnss, sinks, start, yaw):
    """An INS aided by positions alone, since NMEA has no vertical velocity; mounted and noisy as configs/drives says."""
    def reference(name, fields):
        return {"type": "csv/csv", "path": f"{DRIVE}/reference_{name}.csv.gz", "time": {"column": "t_s"},
                "columns": {field: {"column": column, "unit": unit} for field, column, unit in fields}}
    vector = {"type": "vector", "size": 3}
    return {
        "binnacle": 1,
        "sources": {"raw_imu": {"max_gap": "50 ms", **imu}, "gnss": {"type": "nmea", "epoch": EPOCH, **gnss},
                    "truth": reference("position", [("lat", "lat_deg", "deg"), ("lon", "lon_deg", "deg"),
                                                    ("height", "height_m", "m")])},
        "transforms": {"imu": {"type": "rotate_axes", "input": "raw_imu", "roll": "-1.17 deg", "pitch": "-0.02 deg",
                               "yaw": "2.59 deg", "flip": "flu_to_frd"}},
        "filters": {"ins": {
            "history": "2 s",
            "blocks": {"position": {"type": "position", "init": start, "sigma": "3 m"},
                       "velocity": {"type": "velocity", "init": {"vn": 0, "ve": 0, "vd": 0}, "sigma": "0.3 m/s"},
                       "attitude": {"type": "attitude", "init": {"roll": 0, "pitch": 0, "yaw": f"{yaw} deg"}, "sigma": "3 deg"},
                       "gyro_bias": {**vector, "unit": "rad/s", "init": 0, "sigma": "0.5 deg/s"},
                       "accel_bias": {**vector, "unit": "m/s^2", "init": 0, "sigma": "0.2 m/s^2"}},
            "process": {
                "strapdown": {"type": "phi_error", "input": "imu",
                              "blocks": {name: name for name in ("position", "velocity", "attitude", "gyro_bias", "accel_bias")},
                              "gyro_noise": "2e-4 rad/s/sqrt(Hz)", "accel_noise": "0.02 m/s^2/sqrt(Hz)"},
                "gyro_drift": {"type": "random_walk", "blocks": {"x": "gyro_bias"}, "q": "1e-5 rad/s/sqrt(s)"},
                "accel_drift": {"type": "random_walk", "blocks": {"x": "accel_bias"}, "q": "1e-3 m/s^2/sqrt(s)"}},
            "measurements": {"fix": {"channel": "gnss", "type": "position_fix", "blocks": {"position": "position"},
                                     "sigma": ["1.5 m", "1.5 m", "3 m"]}}}},
        "reference": [{"channel": "truth", "blocks": {"ins/position": ["lat", "lon", "height"]}, "invalid": 0}],
        "record": {"every": "0.5 s"},
        "sinks": sinks,
    }


def terminal():
    master, slave = pty.openpty()
    tty.setraw(master, termios.TCSANOW)
    return master, os.ttyname(slave), slave


def figures(name):
    with open(f"{name}/summary.json") as file:
        ins = json.load(file)["filters"]["ins"]
    for key in ("filter_s",):
        ins.pop(key)
    for measurement in ins["measurements"].values():
        for key in ("replayed", "longest_delay_s"):
            measurement.pop(key, None)
    with open(f"{name}/ins.csv") as file:
        return ins, file.read()


def run(whole, name, **more):
    with open(f"{name}.json", "w") as file:
        json.dump(whole, file)
    return subprocess.Popen([BINNACLE, "run", f"{name}.json", "--out", name, "--quiet"], stderr=subprocess.PIPE,
                            stdout=subprocess.PIPE, text=True, **more)


def cable(come_from, go_to):
    """What comes out of one terminal goes into the other."""
    def carry():
        try:
            while data := os.read(come_from, 4096):
                os.write(go_to, data)
        except OSError:
            pass
    threading.Thread(target=carry, daemon=True).start()


class Gpsd:
    def __init__(self, device):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.process = subprocess.Popen([GPSD, "-N", "-n", "-b", "-p", "-S", str(port), device],
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.reports, self.lock = [], threading.Lock()
        for _ in range(100):
            try:
                self.client = socket.create_connection(("127.0.0.1", port))
                break
            except OSError:
                time.sleep(0.1)
        self.client.sendall(b'?WATCH={"enable":true,"json":true};\n')
        self.is_open = threading.Event()
        threading.Thread(target=self.collect, daemon=True).start()
        assert self.is_open.wait(20), "gpsd did not open its device"

    def collect(self):
        for line in self.client.makefile():
            report = json.loads(line)
            if "activated" in line:
                self.is_open.set()
            with self.lock:
                self.reports.append(report)

    def positions(self):
        with self.lock:
            return [report for report in self.reports if report["class"] == "TPV" and "lat" in report]


def check(condition, *text):
    if not condition:
        sys.exit(" ".join(map(str, text)))


class Receiver:
    """The drive as text, and the configs that read it."""

    def __init__(self):
        imu, self.fixes = list(rows("imu")), list(rows("gnss"))
        first = self.fixes[0]
        self.start = {"lat": f"{first['lat_deg']} deg", "lon": f"{first['lon_deg']} deg", "height": first["height_m"]}
        self.yaw = next(rows("reference_attitude"))["yaw_deg"]
        self.columns = {name: {"column": column, "unit": unit, "kind": "rate"} for name, column, unit in (
            ("wx", "gx_radps", "rad/s"), ("wy", "gy_radps", "rad/s"), ("wz", "gz_radps", "rad/s"),
            ("fx", "ax_mps2", "m/s^2"), ("fy", "ay_mps2", "m/s^2"), ("fz", "az_mps2", "m/s^2"))}
        self.header = ",".join(imu[0]) + "\n"
        lines = [(row["t_s"], 0, ",".join(repr(value) for value in row.values()) + "\n") for row in imu]
        lines += [(row["t_s"] + 0.08, 1, of_receiver(row)) for row in self.fixes]  # a receiver computes for a while
        self.lines = [(kind, text) for _, kind, text in sorted(lines)]

    def config(self, imu, gnss, sinks):
        return config({**imu, "columns": self.columns}, gnss, sinks, self.start, self.yaw)

    def run_recorded(self):
        """The same sentences and rows, from files."""
        with open("imu.csv", "w") as file:
            file.write(self.header + "".join(text for kind, text in self.lines if kind == 0))
        with open("receiver.nmea", "w", newline="") as file:
            file.write("".join(text for kind, text in self.lines if kind == 1))
        process = run(self.config({"type": "csv/csv", "path": "imu.csv", "time": {"column": "t_s"}},
                                  {"path": "receiver.nmea"}, {}), "recorded")
        _, err = process.communicate(timeout=100)
        check(process.returncode == 0, "recorded:", err)
        return figures("recorded")

    def run_live(self, out_device):
        (imu, imu_device, _), (gnss, gnss_device, _) = terminal(), terminal()
        sinks = {"ins": {"type": "stream/json_writer", "input": "ins", "to": "file:ins.jsonl"},
                 "nmea": {"type": "nmea_writer", "input": "ins", "to": f"serial://{out_device}?baud=4000000",
                          "epoch": EPOCH, "geoid_separation": "0 m",
                          "fields": {"lat": "position.lat", "lon": "position.lon", "height": "position.height",
                                     "vn": "velocity.vn", "ve": "velocity.ve", "yaw": "attitude.yaw"}}}
        process = run(self.config({"type": "stream/csv", "from": f"serial://{imu_device}?baud=921600",
                                   "time": {"key": "t_s"}},
                                  {"from": f"serial://{gnss_device}?baud=115200"}, sinks), "live")
        while len(os.listdir(f"/proc/{process.pid}/task")) < 2:  # the writer's: then the terminals are open
            time.sleep(0.1)
        time.sleep(0.5)
        os.write(imu, self.header.encode())
        for kind, text in self.lines:
            os.write((imu, gnss)[kind], text.encode())
        before = -1
        while before != (before := os.path.getsize("ins.jsonl")) or before == 0:
            time.sleep(1)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
        check(process.returncode == 0, "live:", process.returncode, err)
        return figures("live"), err


def compare(positions):
    """What gpsd has, and what the filter sent: how many, and how far apart [m]."""
    sent = {}
    with open("ins.jsonl") as file:
        for sample in map(json.loads, file):
            sent.setdefault(round(sample["t"], 3), []).append(sample)
    most = 0.0
    for report in positions:
        hours, minutes, seconds = re.match(r"2026-11-23T(\d+):(\d+):([\d.]+)Z", report["time"]).groups()
        t = round(int(hours) * 3600 + int(minutes) * 60 + float(seconds) - EPOCH_SECONDS, 3)
        check(t in sent, f"gpsd has a position at {t} s, the filter sent none")
        # Each late fix gives the present another estimate, and gpsd joins the sentences of one time: where it has two,
        # the latitude may be of the later one and the height of the earlier one.
        most = max([most] + [min(values) for values in zip(*(apart(report, sample) for sample in sent[t]))])
    check(len(positions) + 3 >= len(sent), f"gpsd has {len(positions)} positions, the filter sent {len(sent)}")
    check(most < 0.002, f"gpsd's positions are {most} m off")
    return len(sent), most


def apart(report, sample):
    """How far gpsd's position is from the filter's, horizontally and in height [m]."""
    north = (report["lat"] - math.degrees(sample["position.lat"])) * 111e3
    east = (report["lon"] - math.degrees(sample["position.lon"])) * 111e3 * math.cos(sample["position.lat"])
    return math.hypot(north, east), abs(report["altHAE"] - sample["position.height"])


def main():
    if not os.path.isdir(DRIVE) or not GPSD:
        print("skipped: no " + (f"data at {DRIVE}" if GPSD else "gpsd (Debian package gpsd)"))
        return SKIPPED
    folder = tempfile.mkdtemp()
    os.chdir(folder)
    receiver = Receiver()
    expected = receiver.run_recorded()
    check(expected[0]["measurements"]["fix"]["accepted"] > 0.95 * len(receiver.fixes), json.dumps(expected[0], indent=1))
    error = expected[0]["reference"]["position.horizontal"]["rms"]
    check(error < 3, f"{error} m from the reference")

    (out, out_device, _), (to_gpsd, gpsd_device, _) = terminal(), terminal()
    gpsd = Gpsd(gpsd_device)
    cable(out, to_gpsd)
    found, err = receiver.run_live(out_device)
    check(found == expected, "the live run is another than the recorded one:", err, json.dumps(found[0], indent=1),
          json.dumps(expected[0], indent=1))
    sent, most = compare(gpsd.positions())
    print(f"{len(receiver.lines)} lines in, {sent} estimates out; gpsd has them, at most {1e3 * most:.2f} mm off")
    gpsd.process.kill()
    shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
