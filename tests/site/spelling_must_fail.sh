#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# spelling.py sees a misspelt word and a list out of order: spelling_must_fail.sh PYTHON
set -euo pipefail
python=$1
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
. "$here/common.sh"
need_packages
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
mkdir -p "$scratch/sdk/docs"
# spelling PAGE WORDS
spelling() {
  printf '%s\n' "$1" >"$scratch/sdk/docs/page.md"
  printf '%s' "$2" >"$scratch/words.txt"
  "$python" "$here/spelling.py" "$scratch" "$scratch/words.txt"
}

words=$'Kalman\npseudorange\n'
spelling $'# Metres\n\nPseudorange: `recieved` is code, and so is\n\n```sh\nrecieve\n```\n\nbut [recognized](recieved.md) is not. Kalman\'s' "$words"
refused "sdk/docs/page.md:3: recieved" spelling $'# Metres\n\nThis was recieved.' "$words"
refused "sdk/docs/page.md:1: behavior" spelling "American behavior" "$words"
refused "sdk/docs/page.md:1: Pseudoranges" spelling "Pseudoranges" "$words"
refused "not sorted, or a word twice, at pseudorange" spelling "Kalman" $'pseudorange\nKalman\n'
refused "not sorted, or a word twice, at Kalman" spelling "Kalman" $'Kalman\nKalman\n'
