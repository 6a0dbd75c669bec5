#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Headers of the program that embeds a filter stay light: preprocessed lines that are not blank, without Eigen and nlohmann.
# preprocessed.sh COMPILER FOLDERS LIMIT HEADER…; FOLDERS has : between.
set -euo pipefail
compiler=$1 limit=$3 failed=0
IFS=: read -ra folders <<<"$2"
shift 3
for header; do
  text=$(printf '#include <%s>\n' "$header" | "$compiler" -std=c++20 -E -x c++ "${folders[@]/#/-I}" -)
  lines=$(grep -cvE '^#|^[[:space:]]*$' <<<"$text")
  echo "$header: $lines preprocessed lines"
  [ "$lines" -le "$limit" ] || failed=1
  ! grep -oE '^# 1 "[^"]*/(Eigen/Core|nlohmann/json.hpp)"' <<<"$text" | head -n 1 || failed=1
done
[ "$failed" = 0 ] || echo "FAILED: at most $limit lines, neither Eigen nor nlohmann"
exit "$failed"
