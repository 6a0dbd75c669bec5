#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Configures the project as where pybind11 is missing: it says what is left out, and all else is there.
# without_pybind11.sh SOURCE CMAKE
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

"$cmake" -S "$source" -B "$scratch/build" -DCMAKE_DISABLE_FIND_PACKAGE_pybind11=ON -DBUILD_TESTING=OFF >"$scratch/log" 2>&1 ||
  fail "the project does not configure without pybind11"
grep -q 'Left out: python, without all of the Debian packages pybind11-dev' "$scratch/log" || fail "nothing says what is left out"
"$cmake" --build "$scratch/build" --target help >"$scratch/targets"
grep -qE '^(... )?binnacle(:|$)' "$scratch/targets" || fail "there is no command to build"
! grep -qE '^(... )?binnacle_python' "$scratch/targets" || fail "the package is built all the same"
! "$cmake" --build "$scratch/build" --target python >"$scratch/log" 2>&1 || fail "what is left out is built"
grep -q 'Left out when this was configured: python, .* sdk/run --python installs them' "$scratch/log" || fail "nothing says how the package is built"
! grep -q dist-packages "$scratch/build/cmake_install.cmake" || fail "the package is installed all the same"
