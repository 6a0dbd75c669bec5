# SPDX-License-Identifier: Apache-2.0
"""Runs the command on hostile inputs: in how long, with how much memory, to what end."""

import os
import pathlib
import resource
import signal
import subprocess
import time

import pytest

PROJECT = pathlib.Path(os.environ["BINNACLE_PROJECT"])
COMMAND = os.environ["BINNACLE_COMMAND"]


class Ended:
    """How a process ended: exit status, or the signal's number negated; what it wrote; seconds of the clock and of processors;
    peak of its memory [MiB]."""

    def __init__(self, process, out, err, seconds, usage):
        self.status = process.returncode
        self.out, self.err = out, err
        self.seconds, self.work = seconds, usage.ru_utime + usage.ru_stime
        self.peak = usage.ru_maxrss >> 10

    def refused(self, status, *words):
        """It ended with the status, and its messages have the words."""
        assert self.status == status, f"status {self.status}: {self.err[:2000]}"
        for word in words:
            assert word in self.err, f"no {word!r} in: {self.err[:2000]}"


@pytest.fixture
def binnacle(tmp_path):
    """Runs `binnacle ARGUMENTS` in a folder of the test's own, with at most `memory` MiB of address space, for `within` seconds.
    `closed`: numbers of streams that it begins without; `asked`: after so many seconds it gets SIGTERM."""

    def run(*arguments, within=20, memory=4096, closed=(), asked=None, stdin=subprocess.DEVNULL):
        def limits():
            resource.setrlimit(resource.RLIMIT_AS, (memory << 20, memory << 20))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            for number in closed:
                os.close(number)

        files = [open(tmp_path / name, "w+b") for name in (".stdout", ".stderr")]
        begin = time.monotonic()
        process = subprocess.Popen([COMMAND, *map(str, arguments)], cwd=tmp_path, stdin=stdin, stdout=files[0], stderr=files[1], preexec_fn=limits)
        if asked is not None:
            time.sleep(asked)
            process.send_signal(signal.SIGTERM)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                process.returncode = os.waitstatus_to_exitcode(status)
                break
            if time.monotonic() - begin > within:
                process.kill()
                process.wait()
                pytest.fail(f"not over after {within} s: {' '.join(map(str, arguments))}")
            time.sleep(0.005)
        seconds = time.monotonic() - begin
        texts = []
        for file in files:
            file.seek(0)
            texts.append(file.read().decode(errors="replace"))
            file.close()
        return Ended(process, *texts, seconds, usage)

    return run


@pytest.fixture
def write(tmp_path):
    """Writes a file of the test's folder: text, bytes, or JSON of anything else. Returns its path."""
    import json

    def write(name, content):
        path = tmp_path / name
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            path.write_text(content if isinstance(content, str) else json.dumps(content))
        return path

    return write
