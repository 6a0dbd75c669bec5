#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# `must_fail.sh RULE TREE`: a check is worth what it catches. The lines of TREE that end in "bad" are reported, by path
# and line, and no others. An @ is taken out before, so that no bad word stands in the project itself.
set -euo pipefail

rule=$1
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
cp -r -- "$2/." "$tree"
find "$tree" -type f -exec sed -i 's/@//g' {} +

expected=$(cd "$tree" && grep -rnE '(//|#) bad$' . | sed 's/^\.\/\([^:]*:[0-9]*\):.*/\1/' | sort)
[ -n "$expected" ] || { echo "no line of $2 is marked bad"; exit 1; }

status=0
output=$(bash "$(dirname -- "${BASH_SOURCE[0]}")/check.sh" "$rule" "$tree") || status=$?
reported=$(sed 's/^\([^:]*:[0-9]*\):.*/\1/' <<<"$output" | sort -u)

echo "$output"
[ "$status" != 77 ] || exit 77
if [ "$status" != 1 ] || [ "$reported" != "$expected" ]; then
  echo "exit status $status; expected (<) and reported (>) lines differ:"
  diff <(echo "$expected") <(echo "$reported")
  exit 1
fi
