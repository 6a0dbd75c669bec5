#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a Python wheel: wheel.py PACKAGE VERSION FOLDER

PACKAGE is the folder of the package binnacle, with an installation of the command inside. Its manual pages and completion move to
where an environment has those. Prints the file.
"""
import base64
import hashlib
import os
import re
import subprocess
import sys
import time
import zipfile
from pathlib import Path

METADATA = """\
Metadata-Version: 2.1
Name: binnacle
Version: {version}
Summary: Error-state Kalman filters for INS/GNSS and other sensors, composed from JSON
License: Apache-2.0
License-File: LICENSE
Requires-Python: {python}
Requires-Dist: numpy
Classifier: Operating System :: POSIX :: Linux
Classifier: Programming Language :: C++
Classifier: Programming Language :: Python :: 3
Classifier: Topic :: Scientific/Engineering
"""

# pip puts the environment's Python in place of the first line. The package is not imported: that would load numpy.
COMMAND = """\
#!python
import importlib.util
import os
import sys

package = importlib.util.find_spec("binnacle").submodule_search_locations[0]
command = os.path.join(package, "bin", "binnacle")
os.execv(command, [command, *sys.argv[1:]])
"""


def glibc(package):
    """The newest version of glibc that something in the package needs: (2, 36)"""
    newest = (2, 17)
    for path in package.rglob("*"):
        if path.is_file() and path.open("rb").read(4) == b"\x7fELF":
            symbols = subprocess.run(["objdump", "-T", path], capture_output=True, text=True).stdout
            newest = max([newest, *((2, int(minor)) for minor in re.findall(r"GLIBC_2\.(\d+)", symbols))])
    return newest


class Wheel:
    def __init__(self, path):
        when = time.gmtime(max(int(os.environ.get("SOURCE_DATE_EPOCH", 0)), 315532800))[:6]  # zip begins in 1980
        self.file, self.when, self.records = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9), when, []

    def write(self, name, content, mode=0o644):
        info = zipfile.ZipInfo(name, self.when)
        info.external_attr = (0o100000 | mode) << 16
        info.compress_type = zipfile.ZIP_DEFLATED
        self.file.writestr(info, content)
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        self.records.append(f"{name},sha256={digest},{len(content)}")

    def close(self, name):
        self.records.append(f"{name},,")
        info = zipfile.ZipInfo(name, self.when)
        info.external_attr = 0o100644 << 16
        self.file.writestr(info, "\n".join(self.records) + "\n")
        self.file.close()


def main():
    package, version, folder = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    cores = list(package.glob("_core.cpython-*.so"))
    if len(cores) != 1:
        sys.exit(f"wheel.py: {package} has {len(cores)} modules _core, not one")
    digits = re.search(r"cpython-3(\d+)-", cores[0].name)[1]
    tag = "cp3{0}-cp3{0}-manylinux_{1}_{2}_x86_64".format(digits, *glibc(package))
    path = folder / f"binnacle-{version}-{tag}.whl"
    information, data = f"binnacle-{version}.dist-info", f"binnacle-{version}.data"
    wheel = Wheel(path)
    for file in sorted(package.rglob("*")):
        name = file.relative_to(package).as_posix()
        if not file.is_file() or name.endswith(".pyc"):  # a folder, or a link to one
            continue
        mode = 0o755 if file.stat().st_mode & 0o100 else 0o644
        shared = re.match(r"share/(man|bash-completion|zsh)/", name)
        wheel.write(f"{data}/data/{name}" if shared else f"binnacle/{name}", file.read_bytes(), mode)
    wheel.write(f"{data}/scripts/binnacle", COMMAND.encode(), 0o755)
    python = f">=3.{digits},<3.{int(digits) + 1}"
    wheel.write(f"{information}/METADATA", METADATA.format(version=version, python=python).encode())
    wheel.write(f"{information}/LICENSE", (package / "share/binnacle/LICENSE").read_bytes())
    wheel.write(f"{information}/WHEEL",
                f"Wheel-Version: 1.0\nGenerator: binnacle\nRoot-Is-Purelib: false\nTag: {tag}\n".encode())
    wheel.close(f"{information}/RECORD")
    print(path)


main()
