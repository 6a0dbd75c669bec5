#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What ctest and tests/run make of the sample's cases: seen_by_ctest.sh CTEST SCRATCH SAMPLE PROJECT [OPTIONS]
# OPTIONS make Catch2 fail where no case is run.
set -euo pipefail
ctest=$1 scratch=$2 sample=$3 project=$4 options="${*:5}"
rm -rf -- "$scratch"
mkdir -p "$scratch/junit"

# One test of all cases, and one of the first alone, as tests/tiers.cmake registers them.
cat >"$scratch/CTestTestfile.cmake" <<TESTS
add_test("all" "$sample")
add_test("one" "$sample" "one that skips" $options)
add_test("others" "$sample" "~one that skips" "~one that fails\\, then*")
add_test("none" "$sample" "no such case*" $options)
set_tests_properties("all" "one" "others" "none" PROPERTIES SKIP_RETURN_CODE 77 ENVIRONMENT "BINNACLE_JUNIT=$scratch/junit/sample.xml")
TESTS

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

# shows BINNACLE_SAMPLE TEST WORDS: ctest's line of that test has the words.
shows() {
  local line
  line=$(BINNACLE_SAMPLE=$1 "$ctest" --test-dir "$scratch" --no-tests=error -R "^$2\$" 2>&1 | grep -F "Test #" | head -n 1 || true)
  [[ $line == *"$3"* ]] || fail "with BINNACLE_SAMPLE=$1 ctest shows '$line', not '$3'"
}
# summary WORDS: of the skipped cases, as tests/run prints it.
summary() {
  local said
  said=$(. "$project/tests/summary.sh" && skipped_cases "$scratch/junit")
  [[ $said == "$1" ]] || fail "tests/run prints '$said', not '$1'"
}

shows "" one Passed
summary ""
shows skip one "***Skipped"
summary "1 case skipped: as BINNACLE_SAMPLE asked"
shows fail one "***Failed"
summary ""
# Of several cases in one process: skipped only if all are, and one that is does not vanish.
shows skip all Passed
summary "1 case skipped: as BINNACLE_SAMPLE asked"
shows "fail then skip" all "***Failed"
summary ""
shows 77 all "***Failed"
shows 77 others "***Failed"
shows "fail then skip" others Passed
shows "" none "***Failed"

# The file has each case with its time, what failed with its place.
BINNACLE_SAMPLE=77 BINNACLE_JUNIT=$scratch/sample.xml "$sample" >/dev/null && fail "77 failed checks are no failure"
[ "$(grep -c '^<testcase name=".*" time="[0-9.]*" processor="[0-9.]*">' "$scratch/sample.xml")" = 5 ] || fail "not five cases in the file"
grep -q '^<failure message=".*sample[.]cpp:[0-9]*: ' "$scratch/sample.xml" || fail "a failure without its place"
[ "$(tail -n 1 "$scratch/sample.xml")" = "</testsuite>" ] || fail "the file has no end"
