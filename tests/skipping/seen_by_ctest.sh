#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What ctest makes of the sample's tests: seen_by_ctest.sh CTEST BUILD_FOLDER SAMPLE
set -euo pipefail
ctest=$1 folder=$2 sample=$3

# shows BINNACLE_SAMPLE TEST WORDS: ctest's line of that test has the words.
shows() {
  local line
  line=$(BINNACLE_SAMPLE=$1 "$ctest" --test-dir "$folder" --no-tests=error -R "^skipping: ?$2\$" 2>&1 |
    grep -F "Test #" | head -n 1 || true)
  [[ $line == *"$3"* ]] || {
    printf 'FAILED: with BINNACLE_SAMPLE=%s ctest shows\n%s\nand not "%s"\n' "$1" "$line" "$3" >&2
    exit 1
  }
}
shows "" "one that skips" Passed
shows skip "one that skips" "***Skipped"
shows fail "one that skips" "***Failed"
shows "fail then skip" "one that fails, then skips" "***Failed"
shows 77 "one that fails as often as 77" "***Failed"

# Several tests in one process: skipped only where all were.
BINNACLE_SAMPLE=skip "$sample" >/dev/null || {
  echo "FAILED: one of three was skipped, and the executable failed" >&2
  exit 1
}
