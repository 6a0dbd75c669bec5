#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Installs a build into a scratch folder and there, as outside projects that know nothing but that, configures, builds and
# tests the examples of the installed sdk/examples, with their own tests in tests/examples: examples.sh BUILD CMAKE CTEST
set -euo pipefail
build=$1 cmake=$2 ctest=$3
unset BINNACLE_PLUGIN_PATH CMAKE_BUILD_TYPE DESTDIR
umask 022

scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
# What is compiled is the same every time but for this folder's name.
export CCACHE_BASEDIR=$scratch CCACHE_NOHASHDIR=1

# step WHAT COMMAND…: its output only when it fails, its time always.
step() {
  local what=$1 begin=$SECONDS
  shift
  "$@" >"$scratch/log" 2>&1 </dev/null || {
    cat "$scratch/log" >&2
    printf 'FAILED: %s\n' "$what" >&2
    exit 1
  }
  printf '%3d s  %s\n' $((SECONDS - begin)) "$what"
}

step "cmake --install" "$cmake" --install "$build" --prefix "$scratch/installed"
cp -R "$scratch/installed/share/binnacle/sdk/examples" "$scratch/examples"
for own in "${0%/*}"/../examples/*.cpp; do
  cp "$own" "$scratch/examples/$(basename "$own" .cpp)/test.cpp"
done
export CMAKE_PREFIX_PATH=$scratch/installed

for example in battery tracker sphere balloon; do
  folder=$scratch/examples/$example
  step "$example: configure" "$cmake" -S "$folder" -B "$folder/build" -DCMAKE_COMPILE_WARNING_AS_ERROR=ON
  step "$example: build" "$cmake" --build "$folder/build"
  step "$example: ctest" "$ctest" --test-dir "$folder/build" --output-on-failure --no-tests=error
  grep -q '0 tests failed out of 3$' "$scratch/log" || {
    printf 'FAILED: %s has not the 3 tests of an example\n' "$example" >&2
    exit 1
  }
done
PATH=$scratch/installed/bin:$PATH
in_balloon() { (cd "$scratch/examples/balloon" && sh one_check.sh); }
step "balloon: one check in this process" in_balloon
