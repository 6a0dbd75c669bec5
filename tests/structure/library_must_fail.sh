#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# `library_must_fail.sh TEXT LIBRARY`: the check of built plugins reports TEXT, and nothing else, for LIBRARY.
set -euo pipefail

text=$1
status=0
output=$(bash "$(dirname -- "${BASH_SOURCE[0]}")/check.sh" libraries "${@:2}") || status=$?

echo "$output"
[ "$status" = 1 ] || { echo "exit status $status"; exit 1; }
[ "$(wc -l <<<"$output")" = 1 ] || { echo "more than one offence"; exit 1; }
grep -qF -- "$text" <<<"$output" || { echo "nothing about '$text'"; exit 1; }
