#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The drive of drive.c by way of ctypes, against the numbers that the program in C prints:
from_python.py LIBRARY PRINT CONFIG PLUGIN"""
import ctypes
import json
import subprocess
import sys
from ctypes import POINTER, Structure, byref, c_char_p, c_double, c_int32, c_int64, c_uint64, c_void_p

LIBRARY, PRINT, CONFIG, PLUGIN = sys.argv[1:]
NO_TIME, STEP, STEPS = -(2**63), 10_000_000, 2000

lib = ctypes.CDLL(LIBRARY)
lib.binnacle_last_error.restype = lib.binnacle_last_error_json.restype = c_char_p
lib.binnacle_verdict_name.restype = c_char_p


class Options(Structure):
    _fields_ = [("size", c_uint64), ("vars", POINTER(c_char_p)), ("var_count", c_uint64),
                ("sets", POINTER(c_char_p)), ("set_count", c_uint64)]


class Sample(Structure):
    _fields_ = [("size", c_uint64), ("t0", c_int64), ("t", c_int64), ("fields", POINTER(c_double)),
                ("field_count", c_uint64), ("row_fields", POINTER(c_double)), ("row_field_count", c_uint64),
                ("covariance", POINTER(c_double)), ("covariance_count", c_uint64)]


class FilterInfo(Structure):
    _fields_ = [("size", c_uint64), ("name", c_char_p), ("blocks", c_uint64), ("measurements", c_uint64),
                ("state_size", c_uint64), ("rows", c_uint64), ("input", c_uint64)]


class BlockInfo(Structure):
    _fields_ = [("size", c_uint64), ("name", c_char_p), ("type", c_char_p), ("outputs", c_uint64),
                ("state_offset", c_uint64), ("state_size", c_uint64), ("first_row", c_uint64), ("rows", c_uint64)]


def call(name, *arguments):
    status = getattr(lib, name)(*arguments)
    if status:
        raise RuntimeError(f"{name}: status {status}: {lib.binnacle_last_error().decode()}")


def doubles(numbers):
    return (c_double * len(numbers))(*numbers)


def given(name, kind, *arguments):
    """What a call gives behind its last pointer."""
    value = kind()
    call(name, *arguments, byref(value))
    return value.value


def read(name, count, *arguments):
    numbers = (c_double * count)()
    call(name, *arguments, numbers, c_uint64(count))
    return list(numbers)


def described(name, kind, *arguments):
    info = kind(size=ctypes.sizeof(kind))
    call(name, *arguments, byref(info))
    return info


def load():
    sets = (c_char_p * 2)(b"/plugins=[]", b"/plugins/-=" + PLUGIN.encode())
    variables = (c_char_p * 1)(b"sigma=3 m")
    composition = c_void_p()
    call("binnacle_load", CONFIG.encode(), byref(Options(ctypes.sizeof(Options), variables, 1, sets, 2)), byref(composition))
    return composition


class Drive:
    def __init__(self, composition, seed=0, run=0):
        self.composition, self.session = composition, c_void_p()
        call("binnacle_open", composition, c_uint64(seed), c_int32(run), byref(self.session))
        self.channels = {name: c_uint64(given("binnacle_find_channel", c_uint64, self.session, name.encode()))
                         for name in ("imu", "gnss", "gps", "ranges", "pulse")}

    def put(self, function, channel, t, fields=(), t0=NO_TIME, rows=(), covariance=()):
        sample = Sample(ctypes.sizeof(Sample), t0, t, doubles(fields), len(fields), doubles(rows), len(rows),
                        doubles(covariance) if covariance else None, len(covariance))
        call(function, self.session, self.channels[channel], byref(sample))

    def steps(self, first, last):
        for k in range(first + 1, last + 1):
            t = k * STEP
            imu = [((k * (3 + i)) % 11 - 5) * 1e-5 for i in range(3)]
            imu += [((k * (2 + i)) % 13 - 6) * 1e-4 for i in range(3, 6)]
            imu[5] -= 0.0981
            if k % 20 == 0:
                self.put("binnacle_add", "imu", t, imu, t - STEP)
                self.put("binnacle_add", "gnss", t, [
                    0.8377580409572782 + (k % 7 - 3) * 1e-7, 0.19198621771937624 + (k % 5 - 2) * 1e-7,
                    500 + (k % 9 - 4) * 0.5 + (1000 if 600 < k < 1000 else 0)])
                call("binnacle_commit", self.session, c_int64(t))
            else:
                call("binnacle_push", self.session, self.channels["imu"], c_int64(t - STEP), c_int64(t), doubles(imu),
                     c_uint64(6))
            if k % 50 == 0:
                z = [4197489.243355404 + (k % 7 - 3) * 0.25, 815909.2567256712 + (k % 5 - 2) * 0.25,
                     4717247.902528144 + (k % 3 - 1) * 0.25] + [((k * i) % 7 - 3) * 0.015625 for i in range(3, 6)]
                P = [(4.0 if i < 3 else 0.0625) if i == j else (1.0 if max(i, j) < 3 else 0.0)
                     for j in range(6) for i in range(6)]
                self.put("binnacle_push_sample", "gps", t + 4_000_000, z, covariance=P)
            if k % 30 == 0:
                rows = [number for i in range(6) for number in (
                    i + 1, 5 + ((k * (i + 1)) % 5 - 2) * 0.25 + (500 if i == 3 and k % 300 == 0 else 0), (i - 2) * 0.125, 1)]
                self.put("binnacle_push_sample", "ranges", t, rows=rows)
            if k % 100 == 0:
                call("binnacle_push", self.session, self.channels["pulse"], c_int64(NO_TIME), c_int64(t), doubles([0.5]),
                     c_uint64(1))

    def read(self):
        s, numbers = self.session, []
        for f in range(given("binnacle_filter_count", c_uint64, self.composition)):
            ident = c_uint64(given("binnacle_filter_at", c_uint64, self.composition, c_uint64(f)))
            about = described("binnacle_describe_filter", FilterInfo, self.composition, ident)
            numbers += read("binnacle_read_state", about.state_size, s, ident)
            numbers += read("binnacle_read_covariance", about.rows**2, s, ident)
            numbers.append(given("binnacle_read_time", c_int64, s, ident))
            numbers += [given(f"binnacle_read_{what}", c_int32, s, ident) for what in ("healthy", "started", "verdict")]
            for b in range(about.blocks):
                block = c_uint64(given("binnacle_block_at", c_uint64, self.composition, ident, c_uint64(b)))
                of = described("binnacle_describe_block", BlockInfo, self.composition, block)
                numbers += read("binnacle_read", of.outputs, s, block) + read("binnacle_read_sigma", of.outputs, s, block)
                numbers += read("binnacle_read_block_covariance", of.rows**2, s, block)
        return [float(number).hex() for number in numbers]


def main():
    expected = [float.fromhex(line).hex() for line in subprocess.run(
        [PRINT, CONFIG, PLUGIN], check=True, capture_output=True, text=True).stdout.split()]
    composition = load()
    drive, log = Drive(composition, 3, 4), []
    snapshot = None
    for second in range(STEPS // 100):
        drive.steps(100 * second, 100 * (second + 1))
        log += drive.read()
        if second == 8:
            size = given("binnacle_snapshot_size", c_uint64, drive.session)
            snapshot = ctypes.create_string_buffer(size)
            call("binnacle_snapshot", drive.session, snapshot, c_uint64(size))
    assert len(expected) > 5000 and log == expected, "other numbers than those of the program in C"

    other = Drive(composition)
    call("binnacle_restore", other.session, snapshot, c_uint64(len(snapshot)))
    other.steps(900, STEPS)
    assert other.read() == drive.read(), "the restored session goes on otherwise"

    ident = c_uint64()
    assert lib.binnacle_find_channel(drive.session, b"imo", byref(ident)) == 2
    [error] = json.loads(lib.binnacle_last_error_json())
    assert error["code"] == "B020" and "did you mean 'imu'?" in error["message"], error
    for opened in (drive, other):
        call("binnacle_close", opened.session)
        assert lib.binnacle_commit(opened.session, c_int64(0)) == 2
    call("binnacle_release", composition)


main()
