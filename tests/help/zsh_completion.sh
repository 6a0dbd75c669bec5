#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Completion in an interactive zsh, in a terminal of its own: zsh_completion.sh COMMAND HELP_FOLDER
set -euo pipefail
command=$1 help=$2
command -v zsh >/dev/null || {
  echo "SKIPPED: no zsh (Debian package zsh)"
  exit 77
}
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
mkdir -p "$scratch/work/out"
cd "$scratch/work"
touch drive.json data.csv plugin.so

cat >"$scratch/cases" <<'END'
binnacle ru|run
binnacle run --vari|--variant
binnacle run d|drive.json
binnacle inspect da|data.csv
binnacle run drive.json --out o|out
binnacle export out --to |csv gpx kml nmea pos
binnacle new plugin sonar --kind |block derived measurement noise process sink source transform
binnacle list |block derived measurement noise process sink source transform
binnacle new p|plugin
binnacle conform p|plugin.so
binnacle describe gauss|gauss_markov
binnacle create csv core/gauss|core/gauss_markov
END
timeout 100 zsh -f "$here/ask_zsh.zsh" "$(dirname -- "$command")" "$help/zsh" "$scratch/cases" >"$scratch/given"
diff "$scratch/cases" "$scratch/given" >&2 || {
  echo "FAILED: > is what zsh gives" >&2
  exit 1
}
