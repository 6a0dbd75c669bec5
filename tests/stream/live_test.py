# SPDX-License-Identifier: Apache-2.0
"""Live sources: what comes in, by whatever way, is what the run over files gives; what is invalid is reported, and never fatal."""
import csv
import json
import os
import pty
import signal
import socket
import subprocess
import sys
import tempfile
import termios
import time
import tty
import unittest

BINNACLE, PROJECT = os.environ["BINNACLE"], os.environ["PROJECT"]
IMU = {"wx": "rad/s", "wy": "rad/s", "wz": "rad/s", "fx": "m/s^2", "fy": "m/s^2", "fz": "m/s^2"}
GNSS = {"lat": "rad", "lon": "rad", "height": "m", "vn": "m/s", "ve": "m/s", "vd": "m/s"}


def fields(units, kind=None):
    return {name: {"unit": unit, **({"kind": kind} if kind else {})} for name, unit in units.items()}


def config(sources, more=None):
    with open(f"{PROJECT}/configs/quickstart.json") as file:
        quickstart = json.loads("\n".join(line for line in file if not line.strip().startswith("//")))
    ins = quickstart["filters"]["ins"]
    start = {"position": ({"lat": "48.137 deg", "lon": "11.575 deg", "height": 520}, "5 m"),
             "velocity": ({"vn": 0, "ve": 0, "vd": 0}, "0.1 m/s"),
             "attitude": ({"roll": 0, "pitch": 0, "yaw": "30 deg"}, "2 deg")}
    for block, (init, sigma) in start.items():
        ins["blocks"][block].update(init=init, sigma=sigma)
    ins["process"]["strapdown"]["input"] = "imu"
    fix = ins["measurements"]["fix"]
    fix["channel"] = "gnss"
    fix["stack"]["position"]["sigma"], fix["stack"]["velocity"]["sigma"] = "2 m", "0.1 m/s"
    whole = {"binnacle": 1, "sources": sources, "filters": {"ins": ins}}
    whole.update(more or {})
    return whole


def stream(address, **more):
    channels = {"imu": {"fields": fields(IMU, "rate")}, "gnss": {"fields": fields(GNSS)}}
    return {"s": {"type": "stream/json", "from": address, "channels": channels, **more}}


def live_config(address, **more):
    text = json.dumps(config(stream(address, **more)))
    return json.loads(text.replace('"input": "imu"', '"input": "s.imu"').replace('"channel": "gnss"', '"channel": "s.gnss"'))


class Live(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        sink = {"imu": ("drive.imu", IMU), "gnss": ("drive.gnss", GNSS)}
        sets = ["/sources/drive/imu_kind=rate", "/evaluate=null"]
        for name, (channel, units) in sink.items():
            columns = {field: {"unit": unit} for field, unit in units.items()}
            sets.append(f"/sinks/{name}=" + json.dumps(
                {"type": "csv_writer", "input": channel, "path": f"{os.getcwd()}/{name}.csv", "columns": columns}))
        options = [option for text in sets for option in ("--set", text)]
        made = subprocess.run([BINNACLE, "run", f"{PROJECT}/configs/quickstart.json", "--quiet", *options],
                              capture_output=True, text=True)
        assert os.path.exists("imu.csv") and os.path.exists("gnss.csv"), made.stderr
        cls.lines = []
        for rank, channel in enumerate(("imu", "gnss")):
            with open(f"{channel}.csv") as file:
                for row in csv.DictReader(file):
                    numbers = ", ".join(f'"{name}": {value}' for name, value in row.items() if name != "t_s" and value)
                    text = f'{{"channel": "{channel}", "t": {row["t_s"]}, {numbers}}}'
                    cls.lines.append((float(row["t_s"]), rank, text))
        cls.lines = [text for _, _, text in sorted(cls.lines)]
        recorded = {"imu": {"type": "csv", "path": "imu.csv", "columns": fields(IMU, "rate")},
                    "gnss": {"type": "csv", "path": "gnss.csv", "columns": fields(GNSS)}}
        cls.expected = cls.figures(cls.run_to_end(config(recorded)).stdout)
        assert cls.expected["measurements"]["fix"]["accepted"] > 150, cls.expected

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.folder.cleanup()

    @staticmethod
    def save(whole):
        with open("config.json", "w") as file:
            json.dump(whole, file)
        return [BINNACLE, "run", "config.json", "--json", "--out", "out"]

    @classmethod
    def run_to_end(cls, whole, text=None):
        return subprocess.run(cls.save(whole), input=text, capture_output=True, text=True, timeout=60)

    def start(self, whole, **more):
        process = subprocess.Popen(self.save(whole), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
        self.addCleanup(process.kill)
        return process

    @staticmethod
    def figures(stdout):
        """What the filter made of it, to the last bit: the figures, and the records."""
        ins = json.loads(stdout)["filters"]["ins"]
        ins.pop("filter_s")
        with open("out/ins.csv") as file:
            ins["records"] = file.read()
        return ins

    def text(self):
        return "\n".join(self.lines) + "\n"

    def interrupt_when_done(self, process, number=signal.SIGINT):
        """Once it has taken in what it was sent: it waits, and uses hardly any time (to poll a file takes some)."""
        used = None
        while True:
            time.sleep(0.3)
            with open(f"/proc/{process.pid}/stat") as file:
                state, *numbers = file.read().rsplit(")", 1)[1].split()
            now = sum(map(int, numbers[10:12]))  # of 30 in 0.3 s
            if state == "Z" or (state == "S" and used is not None and now <= used + 3 and now > 10):
                break
            used = now if state == "S" else None
        process.send_signal(number)
        out, err = process.communicate(timeout=20)
        return out, err, process.returncode

    @staticmethod
    def wait_for_port(kind, port):
        while True:
            with open(f"/proc/net/{kind}") as file:
                if any(f":{port:04X} " in line for line in file):
                    return
            time.sleep(0.05)

    def assert_same(self, stdout, err):
        found = self.figures(stdout)
        self.assertEqual(found.pop("records"), self.expected["records"], err)
        self.assertEqual(found, {key: value for key, value in self.expected.items() if key != "records"}, err)

    def test_a_pipe_gives_what_files_give(self):
        done = self.run_to_end(live_config("stdin:"), self.text())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same(done.stdout, done.stderr)

    def test_rows_of_text_by_two_pipes_give_what_files_give(self):
        sources = {}
        for name, units, kind in (("imu", IMU, "rate"), ("gnss", GNSS, None)):
            os.mkfifo(f"{name}.pipe")
            sources[name] = {"type": "stream/csv", "from": f"file:{os.getcwd()}/{name}.pipe", "columns": fields(units, kind),
                             "time": {"key": "t_s"}}
        history = config(sources)
        history["filters"]["ins"]["history"] = "300 s"  # one may be far ahead of the other
        writers = [subprocess.Popen(f"exec cat {name}.csv > {name}.pipe", shell=True) for name in sources]
        process = self.start(history)
        out, err = process.communicate(timeout=60)
        self.assertEqual([writer.wait() for writer in writers], [0, 0])
        found = self.figures(out)
        for count in ("replayed", "longest_delay_s"):
            found["measurements"]["fix"].pop(count, None)
        self.assertEqual(found["records"], self.expected["records"], err)

    def test_a_file_is_followed_as_it_grows(self):
        with open("growing.jsonl", "w") as file:
            process = self.start(live_config(f"file:{os.getcwd()}/growing.jsonl"))
            for begin in range(0, len(self.lines), 5000):
                file.write("\n".join(self.lines[begin:begin + 5000]) + "\n")
                file.flush()
                time.sleep(0.05)
        out, err, status = self.interrupt_when_done(process)
        self.assertEqual(status, 0, err)
        self.assert_same(out, err)

    def test_a_server_that_comes_late_and_comes_back(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        process = self.start(live_config(f"tcp://127.0.0.1:{port}"))
        time.sleep(0.3)
        with socket.create_server(("127.0.0.1", port)) as server:
            half = len(self.lines) // 2
            for part in (self.lines[:half], self.lines[half:]):
                connection, _ = server.accept()
                with connection:
                    connection.sendall(("\n".join(part) + "\n").encode())
            out, err, status = self.interrupt_when_done(process)
        self.assertEqual(status, 0, err)
        self.assertIn("there is no connection, or it was lost", err)
        self.assertIn("the connection is restored", err)
        self.assert_same(out, err)

    def test_it_is_a_server(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        process = self.start(live_config(f"tcp://:{port}"))
        self.wait_for_port("tcp", port)
        with socket.create_connection(("127.0.0.1", port)) as connection:
            connection.sendall(self.text().encode())
        out, err, status = self.interrupt_when_done(process, signal.SIGTERM)
        self.assertEqual(status, 0, err)
        self.assert_same(out, err)

    def test_datagrams(self):
        with socket.socket(type=socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        process = self.start(live_config(f"udp://:{port}"))
        self.wait_for_port("udp", port)
        with socket.socket(type=socket.SOCK_DGRAM) as sender:
            for begin in range(0, len(self.lines), 50):  # without the last line's end
                sender.sendto("\n".join(self.lines[begin:begin + 50]).encode(), ("127.0.0.1", port))
                time.sleep(0.01)
        out, err, status = self.interrupt_when_done(process)
        self.assertEqual(status, 0, err)
        self.assert_same(out, err)

    def test_datagrams_that_are_lost_are_counted(self):
        with socket.socket(type=socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        process = self.start(live_config(f"udp://:{port}"))
        self.wait_for_port("udp", port)
        process.send_signal(signal.SIGSTOP)
        with socket.socket(type=socket.SOCK_DGRAM) as sender:
            for begin in range(0, 10 * len(self.lines), 50):  # 40 MB, more than a system keeps
                at = begin % len(self.lines)
                sender.sendto("\n".join(self.lines[at:at + 50]).encode(), ("127.0.0.1", port))
            process.send_signal(signal.SIGCONT)
            time.sleep(1)
            sender.sendto(self.lines[-1].encode(), ("127.0.0.1", port))
        _, err, _ = self.interrupt_when_done(process)
        self.assertIn("datagrams so far came faster than the filter runs and were lost", err.replace("\n", " "))

    def test_a_terminal_as_a_receiver(self):
        near, far = pty.openpty()
        tty.setraw(near)
        name = os.ttyname(far)
        process = self.start(live_config(f"serial://{name}?baud=230400"))
        time.sleep(0.5)
        rest = self.text().encode()
        while rest:
            rest = rest[os.write(near, rest[:4096]):]
        out, err, status = self.interrupt_when_done(process)
        os.close(far)
        os.close(near)
        self.assertEqual(status, 0, err)
        self.assert_same(out, err)

    def test_what_is_no_good_is_reported_and_not_fatal(self):
        bad = {'{"channel": "imu", "t": 1': "not a JSON object",
               "[1, 2]": "not a JSON object",
               '{"t": 3, "wx": 1}': 'its "channel" is missing',
               '{"channel": "imux", "t": 3}': "there is no channel 'imux'",
               '{"channel": "imu", "wx": 1}': "it has no time 't'",
               '{"channel": "imu", "t": "soon", "wx": 1}': "it has no time 't'",
               '{"channel": "imu", "t": 1e40, "wx": 1}': "its time is out of range",
               '{"channel": "gnss", "t": 3}': "it has none of its channel's fields",
               '{"channel": "gnss", "t": 0.5, "lat": null, "lon": 1}': "a field is missing, or is not a number",
               "\x00\xff garbage \x07": "not a JSON object"}
        lines = list(self.lines)
        for index, line in enumerate(bad):
            lines.insert(1000 * (index + 1), line)
        done = self.run_to_end(live_config("stdin:"), "\n".join(lines))
        self.assertEqual(done.returncode, 0, done.stderr)
        for why in bad.values():
            self.assertIn(why, done.stderr.replace("\n", " "))
        self.assertIn("B062", done.stderr)
        self.assertEqual(self.figures(done.stdout)["records"], self.expected["records"])

    def shifted(self, channel, first, count, by):
        """`count` of the channel's lines from index `first` on, `by` seconds later; "" and None: of any channel, of all that follow."""
        lines, shifted = list(self.lines), 0
        for index in range(first, len(lines)):
            sample = json.loads(lines[index])
            if channel in sample["channel"] and (count is None or shifted < count):
                lines[index] = json.dumps({**sample, "t": sample["t"] + by})
                shifted += 1
        return "\n".join(lines) + "\n"

    def test_lines_an_hour_ahead_are_left_out_and_the_filter_goes_on(self):
        for channel, first, count, verdict in (("imu", 10000, 1, "ok"), ("gnss", 10000, 1, "ok"), ("imu", 10000, 100, "doubtful"),
                                               ("gnss", 10000, 20, "ok"), ("imu", 30, 1, "ok")):
            with self.subTest(channel=channel, first=first, count=count):
                done = self.run_to_end(live_config("stdin:"), self.shifted(channel, first, count, 3600))
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("its time is far ahead of those before", done.stderr.replace("\n", " "))
                ins = self.figures(done.stdout)
                self.assertEqual(ins["verdict"]["state"], verdict, done.stderr)
                self.assertEqual(ins["end_s"], self.expected["end_s"])
                late = [ins["measurements"][name]["late"] for name in ins["measurements"]]
                self.assertEqual(sum(late), 0)

    def test_a_clock_that_jumps_is_followed(self):
        done = self.run_to_end(live_config("stdin:"), self.shifted("", 10000, None, 100))
        ins = self.figures(done.stdout)
        self.assertEqual(ins["end_s"], self.expected["end_s"] + 100, done.stderr)
        self.assertEqual(ins["input_gaps"], 1)

    def test_what_is_no_good_ends_the_run_if_asked(self):
        lines = self.lines[:1000] + ["garbage"]
        done = self.run_to_end(live_config("stdin:", on_error="stop"), "\n".join(lines))
        self.assertEqual(done.returncode, 5)
        self.assertIn("stdin::1001", done.stderr)
        self.assertIn("it is not a JSON object", done.stderr.replace("\n", " "))

    def test_silence_is_reported_and_its_end(self):
        process = self.start(live_config("stdin:", silence="0.3 s"), stdin=subprocess.PIPE)
        process.stdin.write("\n".join(self.lines[:1000]) + "\n")
        process.stdin.flush()
        time.sleep(1)
        process.stdin.write("\n".join(self.lines[1000:]) + "\n")
        out, err = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 0, err)
        self.assertIn("it has been silent for 0.3 s", err)
        self.assertIn("it came back after", err)
        self.assert_same(out, err)

    def test_a_sample_advances_the_filter_before_the_next_is_there(self):
        whole = live_config("stdin:")
        process = self.start(whole, stdin=subprocess.PIPE)
        process.stdin.write("\n".join(self.lines[:3000]) + "\n")
        process.stdin.flush()
        out, err, status = self.interrupt_when_done(process)
        self.assertEqual(status, 0, err)
        imu = [json.loads(line)["t"] for line in self.lines[:3000] if '"imu"' in line]
        self.assertAlmostEqual(self.figures(out)["end_s"], imu[-1], 9)

    def test_a_live_run_resumes_at_what_arrives_next_and_the_time_between_is_a_hole(self):
        words = self.save(live_config("stdin:"))
        process = subprocess.Popen([*words, "--checkpoint", "checkpoint@10s"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        process.stdin.write("\n".join(self.lines[:10000]) + "\n")
        process.stdin.flush()
        pipe, process.stdin = process.stdin, None  # it stays open
        _, err, status = self.interrupt_when_done(process, signal.SIGKILL)
        pipe.close()
        self.assertEqual(status, -signal.SIGKILL, err)
        first, last = (json.loads(line)["t"] for line in (self.lines[9999], self.lines[11000]))
        rest = "\n".join(self.lines[11000:]) + "\n"
        done = subprocess.run([*words, "--resume", "checkpoint"], input=rest, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("B108", done.stderr)
        ins = self.figures(done.stdout)
        self.assertEqual(ins["input_gaps"], 1)
        self.assertEqual(ins["end_s"], self.expected["end_s"])
        self.assertEqual(ins["verdict"]["state"], "doubtful")
        times = [float(row["t[s]"]) for row in csv.DictReader(ins["records"].splitlines())]
        self.assertEqual(times[0], self.first_record())
        self.assertTrue(all(time < first or time >= last for time in times))
        self.assertGreater(sum(time < first for time in times), 10)

    def first_record(self):
        return float(next(csv.DictReader(self.expected["records"].splitlines()))["t[s]"])

    def test_a_second_signal_ends_it_with_status_one(self):
        process = self.start(live_config("stdin:"), stdin=subprocess.PIPE)
        process.stdin.write("\n".join(self.lines[:10000]) + "\n")
        process.stdin.flush()
        time.sleep(1)
        os.kill(process.pid, signal.SIGSTOP)  # so that both have come before it can end
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGTERM)
        os.kill(process.pid, signal.SIGCONT)
        process.communicate(timeout=20)
        self.assertEqual(process.returncode, 1)

    def test_addresses_that_are_none(self):
        wrong = {"stdin": "did you mean 'stdin:'?", "log.jsonl": "did you mean 'file:log.jsonl'?",
                 "http://x:1": "an address is stdin:, file:PATH", "tcp://localhost": "no port is given",
                 "udp://:70000": "'70000' is not a port", "serial://ttyUSB0": "named by its whole path",
                 "serial:///dev/x?b=1": "the one option of serial:// is ?baud=NUMBER", "stdout:": "did you mean 'stdin:'?"}
        for address, why in wrong.items():
            done = self.run_to_end(live_config(address), "")
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn(why, done.stderr.replace("\n", " "))
            self.assertIn("/sources/s/from", done.stderr.replace("\n", " "))
        for address in ("file:/none/x", "serial:///dev/none", "serial:///dev/null"):
            done = self.run_to_end(live_config(address), "")
            self.assertEqual(done.returncode, 5, done.stderr)
            self.assertIn("B060", done.stderr)

    def test_latency_is_for_recorded_data(self):
        done = self.run_to_end(live_config("stdin:", latency="1 s"), "")
        self.assertEqual(done.returncode, 3)
        self.assertIn("'latency' is for recorded data", done.stderr.replace("\n", " "))


if __name__ == "__main__":
    unittest.main()
