#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes an installation carry the libraries that it needs: carry.py PREFIX NETCDF NO_URLS

NETCDF is the NetCDF library that the command loads by name, NO_URLS the source no_urls.c. Libraries are copied to
PREFIX/lib/carried, and found from where a program or library lies ($ORIGIN), so that PREFIX may be moved. Each but NetCDF gets a
name of its own there: in a Python process another of the same name may be loaded already. Those of SYSTEM stay the
system's: a plugin that is built on a newer system needs its newer libstdc++.
Copies of their licences lie in PREFIX/share/doc/carried. Exit status 1 if something is still needed from elsewhere.
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

SYSTEM = re.compile(r"(ld-linux-x86-64|linux-vdso|lib(c|m|dl|pthread|rt|util|gcc_s|stdc\+\+|z))\.so\b")
FOR_URLS = re.compile(r"lib(curl(-gnutls)?|crypto|xml2)\.so\b")


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def is_dynamic(path):
    with open(path, "rb") as file:
        if file.read(4) != b"\x7fELF":
            return False
    return "NEEDED" in output("readelf", "-d", path)


def dynamic_files(folder):
    return [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.is_symlink() and is_dynamic(path)]


def needed(path):
    return re.findall(r"\(NEEDED\).*\[(.*)\]", output("readelf", "-d", path))


def found(path):
    """Where the loader finds the libraries that a file needs, directly or not, by name; None where it does not."""
    places = {}
    for line in output("ldd", path).splitlines():
        match = re.match(r"\s*(\S+) => (not found|/\S+)", line)
        if match:
            places[match[1]] = None if match[2] == "not found" else Path(match[2])
    return places


def collect(roots):
    """The libraries to carry, by name: what the roots need, and what that needs."""
    carried, waiting = {}, list(roots)
    while waiting:
        path = waiting.pop()
        places = found(path)
        for name in needed(path):
            if SYSTEM.match(name) or FOR_URLS.match(name) or name in carried:
                continue
            if not places.get(name):
                sys.exit(f"carry.py: {path} needs {name}, which is not installed")
            carried[name] = places[name].resolve()
            waiting.append(carried[name])
    return carried


def renamed(name):
    """libfmt.so.9: bn_fmt.so.9, which is as long."""
    if not name.startswith("lib"):
        sys.exit(f"carry.py: {name} does not begin with lib")
    return "bn_" + name[3:]


def version_owners(path):
    """Which library a version of a symbol is wanted from: {"CURL_GNUTLS_3": "libcurl-gnutls.so.4"}"""
    owners, library = {}, None
    for line in output("objdump", "-p", path).splitlines():
        if match := re.match(r"\s+required from (\S+):", line):
            library = match[1]
        elif library and (match := re.match(r"\s+0x\w+ 0x\w+ \d+ (\S+)", line)):
            owners[match[1]] = library
    return owners


def wanted_for_urls(libraries):
    """{library: {version: symbols}} of what is not carried."""
    wanted = {}
    for path in libraries:
        for name in needed(path):
            if FOR_URLS.match(name):
                wanted.setdefault(name, {})
        owners = version_owners(path)
        for symbol, version in re.findall(r" U (\S+?)@(\S+)", output("nm", "-D", "--undefined-only", path)):
            if FOR_URLS.match(owners.get(version, "")):
                wanted[owners[version]].setdefault(version, set()).add(symbol)
    return wanted


def build_without_urls(name, versions, source, folder):
    """A library in place of `name`, with the functions of no_urls.c that are called."""
    script = "".join(
        f"{version} {{ global: {' '.join(symbol + ';' for symbol in sorted(symbols))}"
        f"{' local: *;' if index == 0 else ''} }};\n"
        for index, (version, symbols) in enumerate(sorted(versions.items()))
    )
    path = folder / renamed(name)
    script_file = folder / "versions"
    script_file.write_text(script)
    output("cc", "-O2", "-fPIC", "-shared", "-nostdlib", "-s", f"-Wl,-soname,{path.name}",
           f"-Wl,--version-script={script_file}", "-o", path, source)
    script_file.unlink()
    defined = set(re.findall(r" [TDB] (\S+?)@", output("nm", "-D", "--defined-only", path)))
    missing = set().union(*versions.values()) - defined if versions else set()
    if missing:
        sys.exit(f"carry.py: {source} lacks {', '.join(sorted(missing))}, which is called in {name}")


def copy_licence(library, folder):
    owner = subprocess.run(["dpkg-query", "-S", library], capture_output=True, text=True).stdout
    if not owner and str(library).startswith("/usr/lib"):  # the path before /lib became a link
        owner = subprocess.run(["dpkg-query", "-S", str(library)[4:]], capture_output=True, text=True).stdout
    if not owner:
        sys.exit(f"carry.py: no Debian package has {library}")
    package = re.split("[:,]", owner)[0]
    shutil.copy(f"/usr/share/doc/{package}/copyright", folder / f"{package}.copyright")


def relink(path, names, origin):
    """Exchanges the names in the dynamic strings, where they stand for what is needed, for the library's own name and for the
    owners of versions (of which patchelf 0.14 forgets the last), then sets the search path."""
    section = re.search(r"\] \.dynstr +STRTAB +\w+ (\w+) (\w+)", output("readelf", "-SW", path))
    begin, size = int(section[1], 16), int(section[2], 16)
    content = path.read_bytes()
    strings = content[begin:begin + size]
    for old, new in names.items():
        strings = strings.replace(b"\0" + old.encode() + b"\0", b"\0" + new.encode() + b"\0")
    path.write_bytes(content[:begin] + strings + content[begin + size:])
    output("patchelf", "--set-rpath", origin, path)


def check(prefix, folder):
    faults = []
    for path in dynamic_files(prefix):
        for name, place in found(path).items():
            if not place or not (SYSTEM.match(name) or place.resolve().is_relative_to(prefix)):
                faults.append(f"{path} finds {name}: {place}")
    for path in dynamic_files(folder):
        faults += [line.strip() for line in output("ldd", "-r", path).splitlines() if "undefined symbol" in line]
    if faults:
        sys.exit("carry.py: " + "\n".join(faults))


def main():
    prefix, netcdf, source = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3])
    folder, licences = prefix / "lib/carried", prefix / "share/doc/carried"
    folder.mkdir(parents=True)
    licences.mkdir(parents=True)
    own = dynamic_files(prefix)
    netcdf_name = re.search(r"\(SONAME\).*\[(.*)\]", output("readelf", "-d", netcdf))[1]
    netcdf = netcdf.resolve()
    carried = {netcdf_name: netcdf, **collect([*own, netcdf])}
    urls = wanted_for_urls(carried.values())
    names = {name: renamed(name) for name in [*carried, *urls] if name != netcdf_name}

    for name, versions in urls.items():
        build_without_urls(name, versions, source, folder)
    for name, library in carried.items():
        copy = folder / names.get(name, name)
        shutil.copy(library, copy)
        copy.chmod(0o644)
        relink(copy, names, "$ORIGIN")
        copy_licence(library, licences)
    for path in own:
        if any(name in names for name in needed(path)) or netcdf_name.encode() in path.read_bytes():
            relink(path, names, "$ORIGIN/" + os.path.relpath(folder, path.parent))
    check(prefix, folder)
    size = sum(file.stat().st_size for file in folder.iterdir())
    print(f"carried: {len(carried)} libraries, {size / 1e6:.1f} MB: {' '.join(sorted(carried))}", file=sys.stderr)


main()
