#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The first command of the README, as it is typed in a clone: first_command.sh PROJECT
set -euo pipefail
cd "$1"
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
grep -qE '^sdk/run configs/quickstart.json ' README.md || {
  echo "FAILED: the README has another first command" >&2
  exit 1
}
# Its file binnacle.pth is written into the user's own packages.
PYTHONUSERBASE=$scratch sdk/run configs/quickstart.json >"$scratch/log"
[[ $(tail -n 1 "$scratch/log") == 'verdict: ins ok' ]] || {
  cat "$scratch/log" >&2
  exit 1
}
