#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What is installed is whole: its documents' links, the tutorial's first commands, an example of the gallery, and an
# installation after sdk/run alone, which builds no modules of the command: installed.sh BUILD CMAKE PYTHON
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

# After sdk/run alone: the same script of CMake's, with names of programs and of a plugin that are not built.
sed -E 's,bin/binnacle-(conform|study|describe|inspect|report),bin/never-built-\1,g; s,lib/binnacle/csv[.]so,lib/binnacle/never-built.so,g' \
  "$build/cmake_install.cmake" >"$scratch/install.cmake"
"$cmake" "-DCMAKE_INSTALL_PREFIX=$scratch/partial" -P "$scratch/install.cmake" >"$scratch/log" 2>&1 || {
  cat "$scratch/log" >&2
  fail "cmake --install after sdk/run alone"
}
for left_out in never-built-{conform,study,describe,inspect,report} never-built.so; do
  grep -q "Left out, since .* not built: .*$left_out.*(cmake --build .* --target binnacle_[a-z]*)" "$scratch/log" ||
    fail "nothing says that $left_out was left out, and what builds it"
done
[ -z "$(find "$scratch/partial" -name '*never-built*' -o -name 'binnacle-*' -path '*/bin/*')" ] || fail "the script of CMake's was not changed"
"$scratch/partial/bin/binnacle" version >/dev/null || fail "the command does not run"
status=0
"$scratch/partial/bin/binnacle" list >/dev/null 2>"$scratch/log" || status=$?
[ "$status" = 2 ] || fail "without its module, list ends with status $status"
grep -q "this build has no 'list' (.*/bin/binnacle-describe is missing)" "$scratch/log" || fail "nothing says which module is missing"
