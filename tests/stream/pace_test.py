# SPDX-License-Identifier: Apache-2.0
"""Runs by the clock: a pace changes no figure; what arrived can be run again, to the last bit; estimates at every step of the input."""
import json
import os
import signal
import subprocess
import tempfile
import time
import unittest

BINNACLE, PROJECT = os.environ["BINNACLE"], os.environ["PROJECT"]
TIMEOUT = float(os.environ["TIMEOUT"]) - 20  # before ctest's, which would leave the command behind
QUICKSTART = f"{PROJECT}/configs/quickstart.json"
LATE = '/sources/drive/latency={"uniform": [0, "1.9 s"]}'


class Pace(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        os.chdir(folder.name)
        self.addCleanup(os.chdir, "/")

    @staticmethod
    def words(config, sets, out):
        return [BINNACLE, "run", config, "--quiet", "--out", out, *(word for text in sets for word in ("--set", text))]

    def run_it(self, *more, config=QUICKSTART, sets=(), out="out", status=0, **how):
        done = subprocess.run([*self.words(config, sets, out), *more], capture_output=True, text=True, timeout=TIMEOUT, **how)
        self.assertEqual(done.returncode, status, done.stderr)
        return self.left(out) if status == 0 else done.stderr

    @staticmethod
    def left(out):
        """Summary and records, without what the machine's clock says; and that."""
        with open(f"{out}/summary.json") as file:
            summary = json.load(file)
        for name in ("wall_s",):
            summary.pop(name)
        for figures in summary["filters"].values():
            figures.pop("filter_s")
        live = summary.pop("live", None)
        with open(f"{out}/ins.csv") as file:
            return (summary, file.read()), live

    def test_a_pace_changes_no_figure(self):
        for sets in ((), (LATE, '/filters/ins/history="2 s"'),
                     (LATE, '/filters/ins/history={"length": "2 s", "steps": 50}', "/evaluate/estimates=live")):
            expected, none = self.run_it(sets=sets)
            found, live = self.run_it("--pace", "200", sets=sets)
            self.assertIsNone(none)
            self.assertEqual(found[1], expected[1])
            self.assertEqual(found, expected)
            for channel in ("drive.imu", "drive.gnss", "drive.truth"):
                figures = live["channels"][channel]
                self.assertGreater(figures["samples"], 150)
                self.assertLessEqual(figures["latency_p50_s"], figures["latency_p99_s"])
                self.assertLessEqual(figures["latency_p99_s"], figures["latency_max_s"])
                self.assertGreater(figures["latency_p50_s"], 0)
                self.assertEqual(figures["behind"] > 0, bool(sets))

    def test_it_takes_the_time_of_the_data(self):
        begin = time.monotonic()
        (summary, _), live = self.run_it("--pace", "50")
        ins = summary["filters"]["ins"]
        wanted = (ins["end_s"] - ins["start_s"]) / 50
        self.assertGreater(time.monotonic() - begin, wanted)
        self.assertGreater(live["seconds"], wanted)

    def test_an_interrupted_one_ends_with_results(self):
        process = subprocess.Popen([*self.words(QUICKSTART, (), "out"), "--pace", "1"], stderr=subprocess.PIPE)
        time.sleep(3)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=20), 0, process.stderr.read())
        self.assertLess(time.monotonic() - begin, 10)
        (summary, _), _ = self.left("out")
        self.assertLess(summary["filters"]["ins"]["end_s"], 30)

    def test_what_arrived_can_be_run_again(self):
        for sets in ((), (LATE, '/filters/ins/history="2 s"'),
                     (LATE, '/filters/ins/history={"length": "2 s", "steps": 50}', "/evaluate/estimates=live")):
            expected, _ = self.run_it("--record-input", "input.jsonl", sets=sets)
            plain, _ = self.run_it(sets=sets)
            found, _ = self.run_it("--input", "input.jsonl", sets=sets, out="again")
            self.assertEqual(expected, plain)
            self.assertEqual(found[1], expected[1])
            self.assertEqual(found, expected)

    def test_live_sources_can_be_run_again(self):
        subprocess.run([BINNACLE, "run", f"{PROJECT}/configs/tutorial/data.json", "--var", "folder=.", "--quiet"], check=True)
        config, data = f"{PROJECT}/configs/live/drive.json", ("--var", "data=.")
        with open("imu.csv") as imu:
            expected, live = self.run_it(*data, "--record-input", "input.jsonl", config=config, stdin=imu)
        found, _ = self.run_it(*data, "--input", "input.jsonl", config=config, out="again", stdin=subprocess.DEVNULL)
        self.assertEqual(found[1], expected[1])
        self.assertEqual(found, expected)
        source = live["sources"]["raw_imu"]
        self.assertGreater(source["longest_queue"], 0)
        self.assertEqual((source["lost"], source["unusable"]), (0, 0))

    def test_input_that_is_torn_or_of_something_else(self):
        self.run_it("--record-input", "input.jsonl")
        with open("input.jsonl") as file:
            text = file.read()
        with open("input.jsonl", "w") as file:
            file.write(text[:text.index("\n", len(text) // 2) + 7])  # arrivals differ from run to run: not at a line's end
        done = subprocess.run([BINNACLE, "run", QUICKSTART, "--input", "input.jsonl"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("B144", done.stderr)
        self.assertIn("ends in the middle of line", done.stderr)
        with open("input.jsonl", "w") as file:
            file.write("t,x\n1,2\n")
        self.assertIn("is not a recorded input", self.run_it("--input", "input.jsonl", status=5))
        with open("input.jsonl", "w") as file:
            file.write(text.replace('"lat"', '"latitude"', 1))
        self.assertIn("channel 'drive.gnss' had", self.run_it("--input", "input.jsonl", status=5))
        self.assertIn("cannot be opened", self.run_it("--input", "none.jsonl", status=5))
        self.assertIn("cannot be written", self.run_it("--record-input", "none/input.jsonl", status=2))
        full = "/dev/full"
        if os.path.exists(full):
            self.assertIn("has not all of the input", self.run_it("--record-input", full, status=5))

    def test_what_does_not_go_together(self):
        live = f"{PROJECT}/configs/live/drive.json"
        subprocess.run([BINNACLE, "run", f"{PROJECT}/configs/tutorial/data.json", "--var", "folder=.", "--quiet"], check=True)
        self.assertIn("has a pace of its own", self.run_it("--pace", "1", "--var", "data=.", config=live, status=2))
        self.run_it("--pace", "0", status=2)
        self.run_it("--record-input", "input.jsonl")
        self.assertIn("fixed_lag", self.run_it("--input", "input.jsonl", "--smooth", status=3))

    def test_estimates_at_every_step_of_the_input(self):
        sink = '/sinks/ins={"type": "stream/json_writer", "input": "%s", "to": "file:%s"}'

        def emitted(channel, *sets):
            result, _ = self.run_it(sets=(sink % (channel, f"{os.getcwd()}/ins.jsonl"), "/record/every=0", *sets))
            with open("ins.jsonl") as file:
                return result, [json.loads(line) for line in file]
        usual, measured = emitted("ins")
        expected, steps = emitted("ins", "/filters/ins/emit=input")
        self.assertEqual(usual[1], expected[1])  # the filter itself is as it was
        count = expected[0]["filters"]["ins"]["steps"]
        self.assertGreater(count, 10000)
        self.assertGreaterEqual(len(steps), count)
        self.assertLessEqual(len(steps), count + len(measured))
        by_time = {sample["t"]: sample for sample in steps}
        self.assertTrue(all(by_time[sample["t"]] == sample for sample in measured))
        self.assertEqual(emitted("ins.settled", "/filters/ins/emit=input", '/filters/ins/history="2 s"')[1], steps)
        self.assertIn('"measurements" or "input"', self.run_it(sets=("/filters/ins/emit=always",), status=3))


if __name__ == "__main__":
    unittest.main()
