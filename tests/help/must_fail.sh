#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Help texts that the generator does not understand end it, in the place of empty pages: must_fail.sh PYTHON GENERATE
set -euo pipefail
python=$1 generate=$2
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

# refused TEXT WHY: of a command that prints TEXT as its help.
refused() {
  printf '#!/bin/sh\ncat <<"END"\n%s\nEND\n' "$1" >"$scratch/command"
  chmod +x "$scratch/command"
  if "$python" -B "$generate" "$scratch/command" 1.0 "$scratch/help" >"$scratch/log" 2>&1; then
    echo "FAILED: $2 is taken" >&2
    exit 1
  fi
  [ ! -e "$scratch/help" ] || {
    echo "FAILED: $2 leaves pages" >&2
    exit 1
  }
}
options=$'Options:\n  -h,--help                   Print this help message and exit'
refused $'Runs\n'"$options" "a help without a usage"
refused $'Runs\nUsage: binnacle [OPTIONS]' "a help without options"
refused $'Runs\nUsage: binnacle [OPTIONS]\n\n'"$options" "a command without verbs"
