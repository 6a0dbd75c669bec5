#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What is installed is whole: its documents' links, the tutorial's first commands, an example of the gallery, and an
# installation after sdk/run alone, which builds no conformance suite: installed.sh BUILD CMAKE PYTHON
set -euo pipefail
build=$1 cmake=$2 python=$3
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
unset BINNACLE_PLUGIN_PATH DESTDIR
umask 022

scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

"$cmake" --install "$build" --prefix "$scratch/prefix" >"$scratch/log" 2>&1 || {
  cat "$scratch/log" >&2
  fail "cmake --install"
}
share=$scratch/prefix/share/binnacle
"$python" "$here/links.py" "$share" || fail "the links above"

# The tutorial's first commands, from the installed configs.
mkdir "$scratch/home" && cd "$scratch/home"
PATH=$scratch/prefix/bin:$PATH
copy=$(sed -n 's/^.*`\(cp -R "[^`]*\)`.*$/\1/p' "$share/sdk/docs/tutorial.md")
[ -n "$copy" ] || fail "the tutorial does not say how the installed configs are copied"
sed -n '/^mkdir data$/,/^```$/p' "$share/sdk/docs/tutorial.md" | grep -v '^```' >"$scratch/commands"
[ "$(wc -l <"$scratch/commands")" -ge 5 ] || fail "the tutorial's first commands are not there"
bash -euo pipefail -c "$copy" || fail "$copy"
bash -euo pipefail "$scratch/commands" >"$scratch/log" 2>&1 || {
  cat "$scratch/log" >&2
  fail "the tutorial's first commands"
}
[ -s out/report.html ] || fail "the tutorial's first commands leave no report"

# An example of the gallery, which lies with what is installed.
if ! { binnacle new filter soc --from battery && binnacle run soc.json; } >"$scratch/log" 2>&1; then
  cat "$scratch/log" >&2
  fail "new filter"
fi

# After sdk/run alone: the same script of CMake's, with the name of a program that is not built.
sed 's,bin/binnacle-conform,bin/never-built,g' "$build/cmake_install.cmake" >"$scratch/install.cmake"
"$cmake" "-DCMAKE_INSTALL_PREFIX=$scratch/partial" -P "$scratch/install.cmake" >"$scratch/log" 2>&1 || {
  cat "$scratch/log" >&2
  fail "cmake --install after sdk/run alone"
}
grep -q 'Left out, since it is not built: binnacle-conform' "$scratch/log" || fail "nothing says what was left out"
[ ! -e "$scratch/partial/bin/never-built" ] || fail "the script of CMake's was not changed"
"$scratch/partial/bin/binnacle" list >/dev/null || fail "the command does not run"
