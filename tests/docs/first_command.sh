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
sdk/run configs/quickstart.json >"$scratch/log" 2>"$scratch/errors"
[[ $(tail -n 1 "$scratch/log") == 'verdict: ins ok' ]] || {
  cat "$scratch/log" >&2
  exit 1
}
! grep -q 'binnacle[.]pth' "$scratch/errors" || {
  echo "FAILED: a run without --python changes the user's Python packages" >&2
  exit 1
}

# Without a config it shows what there is; an option of run stands behind the config.
sdk/run --help | grep -q '^usage: sdk/run \[--all\] \[--python\] \[CONFIG \[options\]\]' || {
  echo "FAILED: no usage" >&2
  exit 1
}
status=0
sdk/run --quiet configs/quickstart.json 2>"$scratch/errors" || status=$?
if [ "$status" != 2 ] || ! grep -q 'options of run stand behind CONFIG' "$scratch/errors"; then
  echo "FAILED: an option before the config: status $status" >&2
  exit 1
fi
