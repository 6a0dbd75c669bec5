#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# python_page.py sees a page that is not true: python_page_must_fail.sh PYTHON PROJECT
set -euo pipefail
python=$1 project=$2
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
ln -s "$project/configs" "$scratch/configs"

# refused WHAT PAGE: with the words WHAT.
refused() {
  printf '%s\n' "$2" >"$scratch/page.md"
  if "$python" "$here/python_page.py" "$scratch" page.md >"$scratch/log"; then
    printf 'FAILED: accepted:\n%s\n' "$2" >&2
    exit 1
  fi
  grep -qF "$1" "$scratch/log" || {
    printf 'FAILED: no "%s" in:\n' "$1" >&2
    cat "$scratch/log" >&2
    exit 1
  }
}
fence='```'
refused 'page.md:2: prints' "${fence}python
print(1)
$fence
${fence}text
2
$fence"
refused 'page.md:2: prints' "${fence}python
print('shown nowhere')
$fence"
refused 'page.md", line 3' "${fence}python
x = 1
x = y
$fence"
refused 'has no python block' "${fence}sh
true
$fence"
printf '%s\n' "${fence}python" 'x = 1' "$fence" text "${fence}python" 'print(x)' "$fence" "${fence}text" 1 "$fence" >"$scratch/page.md"
"$python" "$here/python_page.py" "$scratch" page.md
