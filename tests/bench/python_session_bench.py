#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a sample costs that is pushed from Python: `tests/bench/python_session_bench.py [ROUNDS [SAMPLES]]`.

Each round pushes the same numbers in C++ and in Python, in this process, one after the other; times are of this thread's
processor, and figures are medians over the rounds, of ratios and of differences within a round.
"""
import ctypes
import os
import sys
import threading
import time

import binnacle as bn
import numpy as np

PROJECT = os.path.abspath(os.environ.get("PROJECT", "."))
BUILD = os.path.abspath(os.environ.get("BUILD", os.path.join(PROJECT, "build", "release")))
PLUGINS = os.path.join(BUILD, "lib", "binnacle")
CONFIG = os.path.join(PROJECT, "configs", "quickstart.json")


def samples_of(composition, count):
    """The start and the IMU of the quickstart's drive, the IMU over and over."""
    channels = composition.run(keep=["drive.initial", "drive.imu"], records=False, innovations=False).channels
    initial, imu = channels["drive.initial"], channels["drive.imu"]
    fields = np.stack(list(imu.values()), axis=1)[1:]
    fields = np.ascontiguousarray(np.resize(fields, (count, fields.shape[1])))
    t = np.arange(count + 1) * 10_000_000
    return np.array([initial[name][0] for name in initial]), np.ascontiguousarray(initial.covariance[0]), t[:-1], t[1:], fields


class Bench:
    def __init__(self, count):
        self.composition = bn.load(CONFIG)
        self.first, self.P, self.t0s, self.ts, self.fields = samples_of(self.composition, count)
        self.exact = self.t0s.astype("m8[ns]"), self.ts.astype("m8[ns]")
        self.seconds = (self.t0s * 1e-9).tolist(), (self.ts * 1e-9).tolist(), list(self.fields)
        self.library = ctypes.CDLL(os.path.join(BUILD, "lib", "libcpp_pushes.so"))
        self.library.cpp_pushes.restype = ctypes.c_double

    def session(self):
        s = self.composition.session()
        s.push("drive.initial", None, 0, self.first, covariance=self.P)
        return s

    def cpp(self):
        state = np.zeros_like(self.session().state())
        pointer = lambda array: array.ctypes.data_as(ctypes.c_void_p)  # noqa: E731
        seconds = self.library.cpp_pushes(
            CONFIG.encode(), PLUGINS.encode(), b"drive.initial", pointer(self.first), pointer(self.P), b"drive.imu",
            ctypes.c_size_t(len(self.ts)), ctypes.c_size_t(self.fields.shape[1]), pointer(self.t0s), pointer(self.ts),
            pointer(self.fields), pointer(state))
        if seconds < 0:
            sys.exit("cpp_pushes failed")
        return seconds, state

    def timed(self, push):
        s = self.session()
        begin = time.thread_time()
        push(s)
        return time.thread_time() - begin, s.state()

    def many(self, s):
        s.push_many("drive.imu", *self.exact, self.fields)

    def by_channel(self, s):
        push = s.channel("drive.imu").push
        for t0, t, fields in zip(*self.seconds):
            push(t0, t, fields)

    def by_name(self, s):
        push = s.push
        for t0, t, fields in zip(*self.seconds):
            push("drive.imu", t0, t, fields)

    def round(self):
        cpp, expected = self.cpp()
        times = {}
        for way in (self.many, self.by_channel, self.by_name):
            times[way.__name__], state = self.timed(way)
            if state.tobytes() != expected.tobytes():
                sys.exit(f"{way.__name__}: another state than in C++")
        return cpp, times

    def wall(self, push, threads):
        sessions = [self.session() for _ in range(threads)]
        runners = [threading.Thread(target=push, args=(s,)) for s in sessions]
        begin = time.perf_counter()
        for runner in runners:
            runner.start()
        for runner in runners:
            runner.join()
        return time.perf_counter() - begin


def main():
    rounds, count = (int(argument) for argument in (sys.argv[1:] + ["11", "100000"][len(sys.argv) - 1 :]))
    bench = Bench(count)
    bench.round()
    figures = [bench.round() for _ in range(rounds)]
    cpp = np.array([cpp for cpp, _ in figures])
    of = {way: np.array([times[way] for _, times in figures]) for way in figures[0][1]}
    print(f"{count} IMU samples into 15 states, medians of {rounds} rounds, processor time:")
    print(f"C++                 {1e6 * np.median(cpp) / count:7.3f} us a sample")
    print(f"push_many           {1e6 * np.median(of['many']) / count:7.3f} us, {np.median(of['many'] / cpp):.3f} x C++")
    for way, what in (("by_channel", "imu.push(t0, t, f)"), ("by_name", 's.push("imu", …)  ')):
        each, more = (1e6 * np.median(times) / count for times in (of[way], of[way] - cpp))
        print(f"{what}  {each:7.3f} us, {more:.3f} us more than C++")
    for push, what in ((bench.many, "push_many"), (bench.by_channel, "imu.push, one by one,")):
        one, two = (np.median([bench.wall(push, threads) for _ in range(max(1, rounds // 2))]) for threads in (1, 2))
        print(f"{what} in two threads, each into its session: {two / one:.2f} x the wall clock of one, "
              f"of {os.cpu_count()} processors")


if __name__ == "__main__":
    main()
