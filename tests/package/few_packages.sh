#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Configures the project with no more packages than section `run` of sdk/packages.txt has: what needs others is left out aloud,
# and its target fails with the command that installs them. few_packages.sh SOURCE CMAKE
set -euo pipefail
source=$1 cmake=$2
unset BINNACLE_PLUGIN_PATH CMAKE_BUILD_TYPE DESTDIR

scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
fail() {
  cat "$scratch/log" >&2
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

options=()
for package in NLopt Catch2 pybind11 MPI; do options+=("-DCMAKE_DISABLE_FIND_PACKAGE_$package=ON"); done
"$cmake" -G Ninja -S "$source" -B "$scratch/build" "${options[@]}" >"$scratch/log" 2>&1 || fail "the project does not configure"
for target in tests python binnacle-study; do
  grep -q "Left out: $target, without all of the Debian packages .* \(sdk\|tests\)/run.* installs them" "$scratch/log" ||
    fail "nothing says that $target is left out"
  grep -q "^$target, " "$scratch/build/left_out.txt" || fail "$target is not in left_out.txt"
done
# Each fails as long as its packages are missing.
for target in tests python binnacle-study; do
  ! "$cmake" --build "$scratch/build" --target $target >"$scratch/log" 2>&1 || fail "$target is built"
  grep -q "Left out when this was configured: $target, .* installs them" "$scratch/log" || fail "nothing says how $target is built"
done
"$cmake" --build "$scratch/build" --target help >"$scratch/log"
for target in binnacle plugins binnacle_c binnacle-conform; do grep -qE "^$target: " "$scratch/log" || fail "$target is left out"; done

# With all packages nothing is left out, and nothing has to be thrown away for that.
"$cmake" -S "$source" -B "$scratch/build" "${options[@]/%=ON/=OFF}" >"$scratch/log" 2>&1 || fail "the project does not configure again"
! grep -E '^(tests|binnacle)' "$scratch/build/left_out.txt" || fail "left out, though it is there"
