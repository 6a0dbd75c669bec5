#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Completion as bash calls it: bash_completion.sh COMMAND HELP_FOLDER
set -euo pipefail
command=$1 help=$2
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
# shellcheck source=/dev/null
. "$help/bash/binnacle"
[ "$(complete -p binnacle)" = "complete -F _binnacle binnacle" ] || {
  echo "FAILED: complete -p: $(complete -p binnacle)" >&2
  exit 1
}
mkdir "$scratch/out" && cd "$scratch"
touch drive.json data.csv plugin.so

faults=0
# gives "EXPECTED" WORD…: the last of the words is completed, the first is the verb. An = is a word, as bash takes it apart.
gives() {
  local expected=$1 given
  shift
  COMP_WORDS=("$command" "$@")
  COMP_CWORD=$#
  COMPREPLY=()
  _binnacle 2>/dev/null || true
  given=$(printf '%s\n' "${COMPREPLY[@]}" | sort | tr '\n' ' ')
  [ "${given% }" = "$expected" ] || {
    printf 'FAILED: binnacle %s\n  gives    %s\n  expected %s\n' "$*" "${given% }" "$expected" >&2
    faults=$((faults + 1))
  }
}
roles="block derived measurement noise process sink source transform"

gives "report run" r
gives "--help" --
gives "--variant" run --vari
gives "drive.json out" run ""
gives "drive.json" run d
gives "drive.json out" run --strict --seed 2 --set /title = x ""
gives "drive.json out" check drive.json --json ""
gives "data.csv" inspect da
gives "out" run drive.json --out ""
gives "out" run drive.json --out = o
gives "out" run drive.json --out =
gives "data.csv drive.json" run drive.json --var data = d
gives "csv nc page" run drive.json --only ""
gives "" run drive.json --seed ""
gives "csv gpx kml nmea pos" export out --to ""
gives "csv" export --to = c
gives "data.csv" export out -o da
gives "$roles" new plugin sonar --kind ""
gives "$roles" list ""
gives "plugin" new p
gives "" new plugin ""
gives "out" report out o
gives "out plugin.so" conform ""
gives "gauss_markov" describe gauss
gives "core/gauss_markov" describe core/gauss
gives "core/gauss_markov" create csv core/gauss
exit $((faults > 0))
