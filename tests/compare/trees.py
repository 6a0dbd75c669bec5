# SPDX-License-Identifier: Apache-2.0
"""The two trees that are compared: the base commit in a worktree of its own, and the tree that this file is in."""
import contextlib
import fcntl
import hashlib
import os
import subprocess
import sys
from pathlib import Path

from names import Bad

ROOT = Path(__file__).resolve().parents[2]


def say(text):
    print(f"compare: {text}", file=sys.stderr, flush=True)


def git(folder, *arguments):
    try:
        done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True)
    except FileNotFoundError as error:
        raise Bad("git is not installed") from error
    if done.returncode != 0:
        raise Bad(f"git {' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout.strip()


def commit_of(text):
    return git(ROOT, "rev-parse", "--verify", f"{text}^{{commit}}")


@contextlib.contextmanager
def locked(path, kind, what):
    """Another comparison may use the same base tree: one builds it, all run it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        try:
            fcntl.flock(file, kind | fcntl.LOCK_NB)
        except OSError:
            say(f"waiting for another comparison that {what}")
            fcntl.flock(file, kind)
        yield


class Tree:
    def __init__(self, folder):
        self.folder = Path(folder)
        self.build = self.folder / "build" / "release"
        self.command = self.build / "bin" / "binnacle"

    def make(self, jobs):
        """In release, by the project's own preset; one build at a time, as sdk/setup.sh has it."""
        self.build.mkdir(parents=True, exist_ok=True)
        with locked(self.build / ".lock", fcntl.LOCK_EX, f"builds {self.folder}"):
            log = self.build / "compare.log"
            say(f"building {self.folder} (log: {log})")
            with open(log, "w", encoding="utf-8") as out:
                # Where the command is one program, it has all verbs.
                targets = ["plugins", "verbs" if (self.folder / "sdk/command/study").is_dir() else "binnacle"]
                commands = [["nice", "cmake", "--build", str(self.build), "-j", str(jobs), "--target", *targets]]
                if not (self.build / "build.ninja").exists():
                    commands.insert(0, ["cmake", "--preset", "release"])
                for command in commands:
                    if subprocess.run(command, cwd=self.folder, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL).returncode:
                        sys.stderr.write("".join(open(log, encoding="utf-8", errors="replace").readlines()[-40:]))
                        raise Bad(f"the build of {self.folder} failed (log: {log})")

    def check(self):
        if not self.command.exists():
            raise Bad(f"{self.command} is not there")

    def programs_digest(self):
        """Of the command, its modules and its plugins, byte for byte."""
        digest = hashlib.sha256()
        for path in [self.command] + sorted(self.command.parent.glob("binnacle-*")) + sorted((self.build / "lib").rglob("*.so")):
            digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
        return digest.hexdigest()

    def configs(self):
        folder = self.folder / "configs"
        return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.json"))


def is_at(folder, commit):
    return (Path(folder) / ".git").exists() and git(folder, "rev-parse", "HEAD") == commit


def check_out(folder, commit):
    """The worktree of the base at `folder`, at this commit and with nothing changed in it."""
    folder = Path(folder)
    if not (folder / ".git").exists():
        if folder.exists() and any(folder.iterdir()):
            raise Bad(f"{folder} is not empty and no worktree")
        folder.parent.mkdir(parents=True, exist_ok=True)
        git(ROOT, "worktree", "prune")
        git(ROOT, "worktree", "add", "--detach", str(folder), commit)
    if Path(git(folder, "rev-parse", "--show-toplevel")).resolve() != folder.resolve():
        raise Bad(f"{folder} is no worktree of its own")
    if folder.resolve() == ROOT:
        raise Bad("the base tree is the tree to compare")
    changed = git(folder, "status", "--porcelain")
    if changed:
        raise Bad(f"the base tree {folder} has changes:\n{changed}")
    if git(folder, "rev-parse", "HEAD") != commit:
        git(folder, "checkout", "--detach", commit)


def data_folder(named):
    text = named or os.environ.get("BINNACLE_DATA")
    if text:
        return Path(text).resolve()
    beside = ROOT.parent / "shared" / "data"
    if beside.is_dir():
        return beside.resolve()
    # A worktree elsewhere: beside the repository that it belongs to. A source tarball belongs to none.
    try:
        common = Path(git(ROOT, "rev-parse", "--path-format=absolute", "--git-common-dir"))
    except Bad:
        return beside.resolve()
    return (common.parent.parent / "shared" / "data").resolve()
