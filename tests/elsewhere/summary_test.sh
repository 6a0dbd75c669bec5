#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# summary.py counts what ctest printed, and fails if a test failed or none ran: summary_test.sh PYTHON
set -euo pipefail
python=$1
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

mkdir -p "$scratch/build/release/Testing/Temporary" "$scratch/build/release/junit"
cat >"$scratch/build/release/Testing/Temporary/LastTest.log" <<'LOG'
1/3 Testing: page: cases
1/3 Test: page: cases
Output:
----------------------------------------------------------
SKIPPED: no chromium
<end of output>
LOG
cat >"$scratch/build/release/junit/unit.xml" <<'XML'
<testsuites><testsuite name="unit"><testcase name="a"/><testcase name="b"><skipped message="no data&#10;here"/></testcase>
</testsuite></testsuites>
XML
cat >"$scratch/log" <<'LOG'
    Start 1: unit: cases
1/3 Test #1: unit: cases ......................   Passed    1.50 sec
2/3 Test #2: page: cases ......................***Skipped   0.01 sec
LOG
summary() { "$python" -B "$here/summary.py" trixie "$scratch/log" "$scratch/build" 12 0; }
fail() {
  printf 'FAILED: %s\n%s\n' "$1" "$found" >&2
  exit 1
}

found=$(summary) || fail "a run without failures fails"
grep -qx 'trixie  *2  *1  *0  *1  *12  0' <<<"$found" || fail "the row"
grep -qx 'skipped: page: cases: no chromium' <<<"$found" || fail "the reason"
grep -qx 'cases in tests of several: 2 run, 0 failed, 1 skipped' <<<"$found" || fail "the cases"
grep -qx 'skipped: 1 cases: no data' <<<"$found" || fail "the reason of a case"

echo '3/3 Test #3: sdk: cases .......................***Failed    2.00 sec' >>"$scratch/log"
if found=$(summary); then fail "a failure passes"; fi
grep -qx 'failed: sdk: cases (Failed)' <<<"$found" || fail "what failed"
: >"$scratch/log"
if found=$(summary); then fail "no test at all passes"; fi
