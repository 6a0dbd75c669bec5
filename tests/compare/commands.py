# SPDX-License-Identifier: Apache-2.0
"""Which commands a config is run with, and running them."""
import contextlib
import math
import os
import re
import resource
import signal
import subprocess
from pathlib import Path

from names import Bad, read_json

VERBS = ("run", "study", "covariance")
REFUSED = 3  # exit status of a config that does not load: it has no study, is a part of others, …

_FILE = re.compile(r'"([^"\s]+\.json)(?:#[^"]*)?"')
_DATA = re.compile(r'"(\w+)"\s*:\s*"[./]*shared/data/(\w+)"')


def data_of(configs, name):
    """{variable: kind of data} that this config names, itself or in what it extends: those whose default is in shared/data."""
    seen, todo, found = set(), [(Path(configs) / name).resolve()], {}
    while todo:
        path = todo.pop()
        if path in seen or not path.is_file():
            continue
        seen.add(path)
        text = path.read_text(encoding="utf-8")
        found.update(_DATA.findall(text))
        todo += [(path.parent / other).resolve() for other in _FILE.findall(text)]
    return found


class Plan:
    """plan.json: what is added to a command line, for all configs and for some."""

    def __init__(self, table):
        self.table = table
        for config, entry in table["configs"].items():
            if not set(entry) <= set(VERBS) | {"all", "before", "reason", "stdin"}:
                raise Bad(f"plan.json: {config}: unknown key")

    @classmethod
    def read(cls, path):
        return cls(read_json(path))

    def before(self, config):
        """Configs that are run first, in the same scratch folder."""
        return self.table["configs"].get(config, {}).get("before", [])

    def stdin(self, config):
        """The file that the config reads as its standard input."""
        return self.table["configs"].get(config, {}).get("stdin", os.devnull)

    def words(self, verb, config):
        entry = self.table["configs"].get(config, {})
        return entry.get(verb, self.table["verbs"][verb]) + entry.get("all", [])


class Side:
    """One of the two trees, with the names that it goes by."""

    def __init__(self, name, tree, data, rename_argument, rename_config):
        self.name, self.tree, self.data = name, tree, Path(data)
        self.rename_argument, self.rename_config = rename_argument, rename_config

    def config(self, old):
        return self.rename_config(old)

    def data_missing(self, old):
        kinds = set(data_of(self.tree.folder / "configs", self.config(old)).values())
        return sorted(kind for kind in kinds if not (self.data / kind).is_dir())

    def line(self, plan, verb, old, scratch, out):
        """The command line for the config that the base calls `old`."""
        config = self.config(old)
        words = ["--summary", f"{out}/summary.json"] if verb == "covariance" else ["--out", str(out)]
        words += [word.replace("{scratch}", str(scratch)) for word in plan.words(verb, old)]
        for variable, kind in sorted(data_of(self.tree.folder / "configs", config).items()):
            words += ["--var", f"{variable}={self.data / kind}"]
        named = [self.rename_argument(word) for word in [verb] + words]
        return [str(self.tree.command), named[0], f"configs/{config}"] + named[1:]

    def carry_out(self, plan, verb, old, scratch, limit):
        """Into scratch/out and scratch/data; the exit status and what it said on stderr."""
        for folder in ("out", "data", "before"):
            (scratch / folder).mkdir(parents=True, exist_ok=True)
        for first in plan.before(old):
            done = self._call(self.line(plan, "run", first, scratch, scratch / "before"), scratch, limit)
            if done.status != 0:
                return done
        stdin = plan.stdin(old).replace("{scratch}", str(scratch))
        return self._call(self.line(plan, verb, old, scratch, scratch / "out"), scratch, limit, stdin)

    def _call(self, line, scratch, limit, stdin=os.devnull):
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("BINNACLE_", "OMPI_", "PMIX_", "SLURM_"))}
        environment.update(NO_COLOR="1", LC_ALL="C.UTF-8")
        with open(scratch / "stderr", "wb") as errors, open(stdin, "rb") as given:
            process = subprocess.Popen(line, cwd=self.tree.folder, env=environment, stdin=given,
                                       stdout=subprocess.DEVNULL, stderr=errors, start_new_session=True)
            # Processor time, so that a busy machine skips no config; what sleeps for long is stopped all the same.
            with contextlib.suppress(ProcessLookupError):
                resource.prlimit(process.pid, resource.RLIMIT_CPU, (math.ceil(limit), math.ceil(limit) + 1))
            try:
                status = process.wait(timeout=20 * limit)
                if status == -signal.SIGXCPU:
                    status = None
            except BaseException as error:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
                if not isinstance(error, subprocess.TimeoutExpired):
                    raise
                status = None
        said = (scratch / "stderr").read_text(encoding="utf-8", errors="replace")
        return Done(line, status, said)


class Done:
    """status: None where it took too long."""

    def __init__(self, line, status, said):
        self.line, self.status, self.said = line, status, said

    def first_line(self):
        return self.said.strip().split("\n")[0]
