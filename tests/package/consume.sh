#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Installs a build into a scratch folder, moves it, and there writes, builds, tests and uses plugins of every kind and a
# program with a filter: consume.sh SOURCE BUILD CMAKE CTEST
set -euo pipefail
source=$1 build=$2 cmake=$3 ctest=$4
unset BINNACLE_PLUGIN_PATH CMAKE_PREFIX_PATH CMAKE_BUILD_TYPE DESTDIR
umask 022

scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
# What is compiled is the same every time but for this folder's name.
export CCACHE_BASEDIR=$scratch CCACHE_NOHASHDIR=1

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

# step WHAT COMMAND…: its output only when it fails, its time always.
step() {
  local what=$1 begin=$SECONDS
  shift
  "$@" >"$scratch/log" 2>&1 </dev/null || {
    cat "$scratch/log" >&2
    fail "$what"
  }
  printf '%3d s  %s\n' $((SECONDS - begin)) "$what"
}

# The project's tests, and none at all is a failure.
run_tests() { "$ctest" --test-dir "$1" --output-on-failure --no-tests=error; }

# What a config does with a plugin: every measurement is accepted, or nearly.
run_config() {
  (
    cd -- "$1"
    "$prefix/bin/binnacle" run config.json --summary "$scratch/summary.json"
    grep -q '"accepted": [1-9]' "$scratch/summary.json"
  )
}

# ---- the package, and no word in it of where it came from

step "cmake --install" "$cmake" --install "$build" --prefix "$scratch/installed"
prefix=$scratch/elsewhere
mv "$scratch/installed" "$prefix"
for file in bin/binnacle include/binnacle/{plugin,header_hash,version}.hpp lib/cmake/Binnacle/BinnacleConfig.cmake \
  include/binnacle.h lib/libbinnacle_c.so{,.1} \
  share/binnacle/{README.md,LICENSE,sdk/template/process/plugin.cpp} share/doc/binnacle/copyright; do
  [ -e "$prefix/$file" ] || fail "not installed: $file"
done
if grep -rlF -e "$source" -e "$scratch/installed" "$prefix/lib/cmake" "$prefix/include" "$prefix/share"; then
  fail "the files above name a folder of the machine that built them"
fi
PATH=$prefix/bin:$(dirname -- "$cmake"):$PATH
mkdir "$scratch/home" && cd "$scratch/home"

# ---- a plugin, as the guide describes it: CMake finds the package by the command's place on the PATH

step "binnacle new plugin my_walk" binnacle new plugin my_walk
grep -qF -- "-DCMAKE_PREFIX_PATH=$prefix " "$scratch/log" || fail "new plugin says where the package is not"
code=$(sed -e 's,//.*,,' -e '/^[[:space:]]*$/d' my_walk/plugin.cpp | wc -l)
[ "$code" -le 30 ] || fail "the smallest plugin has $code lines of code; 30 are promised"
# The commands of its own README, which are the guide's too.
sed -n '/^```sh$/,/^```$/p' my_walk/README.md | grep -v '^```' >"$scratch/commands"
in_my_walk() { (cd my_walk && bash -euo pipefail "$scratch/commands"); }
step "my_walk: cmake, ctest and binnacle run, as its README says" in_my_walk
grep -q '0 tests failed out of 2$' "$scratch/log" || fail "not the 2 tests that a plugin has"
if grep -qF "$source" my_walk/build/CMakeCache.txt; then fail "the source tree was found, not the package"; fi

# ---- one of every kind, in one build, without what only the kernel's library needs

kinds="block process measurement noise derived source transform sink"
mkdir kinds
cp "$source/tests/package/kinds/CMakeLists.txt" kinds
for kind in $kinds; do
  step "binnacle new plugin my_$kind" binnacle new plugin "my_$kind" --kind "$kind" --dir kinds
done
step "every kind: configure" "$cmake" -S kinds -B kinds/build -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 \
  -DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
step "every kind: build" "$cmake" --build kinds/build
step "every kind: ctest" run_tests kinds/build
for kind in $kinds; do
  step "my_$kind: binnacle run" run_config "kinds/my_$kind"
done
grep -qx '60 samples, mean .* m' kinds/my_sink/build/tally.txt || fail "the sink wrote something else"

# ---- a program that embeds a filter with that plugin

cp -R "$source/tests/package/embed" embed
step "embed: configure" "$cmake" -S embed -B embed/build -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 \
  -DMY_WALK="$PWD/my_walk/build"
step "embed: build" "$cmake" --build embed/build
step "embed: ctest" "$ctest" --test-dir embed/build --output-on-failure --no-tests=error

# ---- the same in C, with no C++ compiler and nothing but the library, which finds the plugins beside it

cp -R "$source/tests/package/embed_c" embed_c
step "embed_c: configure" env CXX=/bin/false "$cmake" -S embed_c -B embed_c/build -DCMAKE_BUILD_TYPE=Debug \
  -DCMAKE_C_FLAGS="-std=c99 -Wall -Wextra -Wpedantic -Werror" \
  -DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
step "embed_c: build" "$cmake" --build embed_c/build
step "embed_c: ctest" run_tests embed_c/build
