# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# shellcheck disable=SC2154  # binnacle_root is of sdk/setup.sh
# What tests cost, and what their results say beside ctest's closing lines; sourced by tests/run and .ci/run.

# skipped_cases FOLDER [STAMP]: how many cases were skipped inside of tests, by reason, from the JUnit files there; with STAMP
# from those that are newer.
skipped_cases() {
  find "$1" -name '*.xml' ${2:+-newer "$2"} -exec cat {} + 2>/dev/null | { grep -oE '<skipped[^>]*message="[^"]*"' || true; } |
    sed -e 's/.*message="//; s/"$//; s/&lt;/</g; s/&gt;/>/g; s/&quot;/"/g; s/&#10;.*//; s/&amp;/\&/g' | sort | uniq -c | sort -rn |
    while read -r count reason; do
      if [ "$count" = 1 ]; then echo "1 case skipped: $reason"; else echo "$count cases skipped: $reason"; fi
    done
}

# hundredths_of FILE: of the processor time of the children, as the builtin `times` wrote it into the file.
hundredths_of() {
  awk 'NR == 2 { for (i = 1; i <= 2; ++i) { split($i, part, /[ms]/); sum += 6000 * part[1] + 100 * part[2] } printf "%d", sum }' "$1"
}

# shellcheck disable=SC2034  # hundredths is for the caller
# spent: sets hundredths, the processor time of this shell's children that have ended.
spent() {
  local file
  file=$(mktemp)
  times >"$file"  # in this shell: one behind a pipe has no children
  hundredths=$(hundredths_of "$file")
  rm -f -- "$file"
}

# budget NAME: its units in tests/budget.txt.
budget() { awk -v name="$1" '$1 == name { print $2 }' "$binnacle_root/tests/budget.txt"; }

# units HUNDREDTHS UNIT: processor time as units, one digit.
units() { awk -v time="$1" -v unit="$2" 'BEGIN { printf "%.1f", time / 100 / unit }'; }

# exceeds UNITS NAME: more than the budget's limit and 15 %.
exceeds() { awk -v units="$1" -v most="$(budget "$2")" 'BEGIN { exit !(units > 1.15 * most) }'; }
