#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# `printed_words_must_fail.sh PYTHON`: printed_words.py reports a bad word of a verb's --help and one of a description, and
# does not pass where nothing is printed.
set -euo pipefail

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# pretend NAME HELP DESCRIPTION: a command that prints them.
pretend() {
  cat >"$folder/$1" <<END
#!/bin/bash
case "\$*" in
  --help) printf '  %s   Text\n' {a..l}verb ;;
  "averb --help") echo "$2" ;;
  "describe --all") echo "$3" ;;
esac
END
  chmod +x "$folder/$1"
}

# expect STATUS LINES NAME
expect() {
  local status=0 output
  output=$("$python" "$here/printed_words.py" "$folder/$3") || status=$?
  [ "$status" = "$1" ] && [ "$output" = "$2" ] || { echo "$3: exit status $status, expected $1; printed: $output"; exit 1; }
}

python=$1
pretend good "Write the figures" "bias of the range"
expect 0 "" good
pretend help "The run goes on" "bias of the range"
expect 1 "binnacle averb --help:1: goes on: say continues" help
pretend description "Write the figures" "gyro bias, taken off the rate"
expect 1 "binnacle describe --all:1: taken off: say subtracted" description
printf '#!/bin/bash\n' >"$folder/silent"
chmod +x "$folder/silent"
expect 2 "nothing to check: --help lists 0 verbs" silent
