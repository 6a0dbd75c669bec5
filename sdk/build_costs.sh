#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Costs of build steps, by which sdk/progress.sh says how long a build will still take: build_costs.sh BUILD >sdk/build_costs.txt
# BUILD was built from nothing with CCACHE_DISABLE=1. Costs are tenths of a second there; only their ratios matter. A folder
# has the mean of its steps; a step that differs from it by a quarter has a line of its own.
set -euo pipefail
if [ $# -ne 1 ] || [ ! -e "$1/.ninja_log" ]; then
  echo "usage: sdk/build_costs.sh BUILD >sdk/build_costs.txt" >&2
  exit 2
fi
cat <<'HEAD'
# Costs of build steps: COST PATH, in tenths of a second of one machine. Written by sdk/build_costs.sh; only ratios matter.
# A step has the cost of its own line, else of the nearest folder above. link/ is linking, . the mean of all that is compiled.
1 other
HEAD
awk -F '\t' '
  function mean_of(path) { return int(sum[path] / count[path] / 100 + 0.5) }
  function positive(cost) { return cost < 1 ? 1 : cost }
  # An absolute path is that of this machine, of a command of our own, which weighs what others do.
  NF == 5 && $4 !~ /^\// && $4 ~ /[.](o|gch|a|so|so[.][0-9.]+)$|^bin\// { cost[$4 ~ /[.](o|gch)$/ ? $4 : "link/" $4] = $2 - $1 }
  END {
    for (step in cost) {
      path = step
      if (path !~ /^link\//) {
        sum["."] += cost[step]
        ++count["."]
      }
      while (sub(/\/[^\/]*$/, "", path)) {
        sum[path] += cost[step]
        ++count[path]
      }
    }
    for (path in count) if (path ~ /[.]dir$|^[^\/]*$/) print positive(mean_of(path)), path
    for (step in cost) {
      folder = step
      while (sub(/\/[^\/]*$/, "", folder) && folder !~ /[.]dir$|^[^\/]*$/) {}
      own = int(cost[step] / 100 + 0.5)
      if (4 * own > 5 * mean_of(folder) + 4 || 5 * own + 4 < 4 * mean_of(folder)) print positive(own), step
    }
  }' "$1/.ninja_log" | sort -k 2
