#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tests/tiers.py finds tests without a line or with two, lines without a test, patterns without a case: tiers_must_fail.sh PROJECT BUILD
set -euo pipefail
project=$1 build=$2
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

# finds WORDS: of the spoilt copy.
finds() {
  local found
  if found=$(python3 "$project/tests/tiers.py" --build "$build" --tiers "$scratch/tiers.txt" 2>&1); then
    echo "FAILED: accepted, though $1" >&2
    exit 1
  fi
  grep -qF -- "$1" <<<"$found" || {
    printf 'FAILED: not found: %s\n%s\n' "$1" "$found" >&2
    exit 1
  }
}
spoil() { sed "$1" "$project/tests/tiers.txt" >"$scratch/tiers.txt"; }

spoil '/ unit: cases /d' && finds "'unit: cases' has no line"
spoil '$a quick 1 structure: license, bad tree # twice' && finds "'structure: license, bad tree' has the lines "
spoil 's/^quick\( .* structure: license\*\)/all\1/' && finds "'structure: license' is all, and ctest's labels of it are quick structure"
spoil '$a all 1 structure: never there # no test' && finds "no test is named 'structure: never there'"
spoil '$a all 1 nobody: cases: one* # no executable' && finds "there is no 'nobody: cases'"
spoil '$a all 1 skipping: cases: never there* # no case' && finds "no case of skipping: cases is named 'never there*'"
spoil '$a all 1 skipping: cases: one*skips # in the middle' && finds "Catch2 takes a * at the ends of a pattern only"
spoil '$a every 1 structure: license # tier' && finds "not understood: every 1 structure: license # tier"
