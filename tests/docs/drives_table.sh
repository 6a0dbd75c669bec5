#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Prints the tables of configs/drives/README.md: tests/docs/drives_table.sh FOLDER_OF_DRIVES
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: tests/docs/drives_table.sh FOLDER_OF_DRIVES" >&2; exit 2; }
drives=$(realpath "$1")
cd "$(dirname -- "${BASH_SOURCE[0]}")/../.."

run() { build/release/bin/binnacle run "configs/drives/$1.json" --var drives="$drives" "${@:2}" 2>/dev/null; }

# Of the first table of a summary: figure NAME COLUMN (2 rms, 4 p95).
figure() { awk -v name="$1" -v column="$2" '$1 == name { printf "%.2f", $column; exit }'; }

echo "| drive | horizontal RMS / 95 % vs reference | height RMS | velocity RMS | roll, pitch, yaw RMS | horizontal RMS / 95 % vs withheld fixes |"
echo "|---|---|---|---|---|---|"
for drive in long-drive-large-mount parkinglot medium-turn-loop mixed-turns stop-go-large-mount; do
  all=$(run $drive)
  half=$(run $drive --set '/filters/ins/measurements/fix/withhold={"every": 2}' --set '/reference={"withheld": "fix"}')
  of() { figure "$@" <<<"$all"; }
  echo "| $drive | $(of position.horizontal 2) / $(of position.horizontal 4) | $(of position.down 2) |" \
    "$(of velocity.horizontal 2) | $(of attitude.roll 2), $(of attitude.pitch 2), $(of attitude.yaw 2) |" \
    "$(figure position.horizontal 2 <<<"$half") / $(figure position.horizontal 4 <<<"$half") |"
done

echo
echo "| outages | end error, horizontal, m |"
echo "|---|---|"
run outages | awk '
  $1 ~ /^(long_drive|parkinglot|medium_turn_loop|mixed_turns|stop_go)$/ && NF == 8 {
    if (!($1 in list)) order[++drives] = $1
    list[$1] = list[$1] sprintf(" %.1f", $3); value[++n] = $3; sum += $3
    if ($1 " " $2 == "mixed_turns 436") faulty = $3
  }
  END {
    for (i = 1; i <= drives; ++i) print "| " order[i] " |" list[order[i]] " |"
    for (i = 1; i <= n; ++i) for (j = i; j > 1 && value[j - 1] > value[j]; --j) { x = value[j]; value[j] = value[j - 1]; value[j - 1] = x }
    printf "| all %d: median, mean | %.2f, %.2f |\n", n, (value[n / 2] + value[n / 2 + 1]) / 2, sum / n
    printf "| without mixed-turns 436: mean | %.2f |\n", (sum - faulty) / (n - 1)
  }'
