#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The display of a build counts every step, whatever its name, and a fault of the display does not end a build.
# progress_test.sh PROJECT SCRATCH
set -euo pipefail
project=$1 scratch=$2
rm -rf -- "$scratch"
mkdir -p "$scratch"
. "$project/sdk/setup.sh"
binnacle_build=$scratch

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}
shown() { binnacle_every=0 show_progress "$scratch/plan.txt" 2>&1; }

cat >"$scratch/plan.txt" <<'PLAN'
ninja: Entering directory `/somewhere'
[1/6] Building CXX object kernel/CMakeFiles/binnacle_kernel.dir/Unity/unity_0_cxx.cxx.o
[2/6] Building a plugin with /usr/bin/clang++
[3/6] Linking CXX shared library lib/libbinnacle_kernel.so
[4/6] Building /
[5/6] Hashing the public headers
[6/6] Building CXX object elsewhere/new.cpp.o
PLAN
text=$(shown <"$scratch/plan.txt") || fail "it ended with status $?: $text"
case $text in *"building: 6 of 6 steps, 100 %"*"built in "*) ;; *) fail "not every step is counted: $text" ;; esac

# Half of the steps, each as dear as the other, and two seconds for them: two seconds are left, in steps of ten.
printf '[%s/4] Building CXX object elsewhere/%s.o\n' 1 a 2 b 3 c 4 d >"$scratch/plan.txt"
text=$({ sleep 2; sed -n 1,2p "$scratch/plan.txt"; sleep 1; } | shown) || fail "it ended with status $?: $text"
case $text in *"building: 2 of 4 steps, 50 %, about 10 s left"*) ;; *) fail "the time left is missing: $text" ;; esac

# ninja's status is the build's, even if the display fails.
ninja() { for step in 1 2 3; do echo "[$step/3] Building CXX object $step.o" || return 1; done; }
plan_targets() { :; }
show_progress() { return 1; }
ninja_targets all || fail "a fault of the display ended the build"
[ "$(grep -c Building "$scratch/build.log")" = 3 ] || fail "the log is not whole"
ninja() { return 1; }
! ninja_targets all 2>"$scratch/said" || fail "a build that failed passed"
rm -rf -- "$scratch"
