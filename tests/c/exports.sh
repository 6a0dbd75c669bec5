#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The library exports what the header declares, and nothing else: exports.sh LIBRARY HEADER
set -euo pipefail
export LC_ALL=C
exported=$(nm -D --defined-only "$1" | awk '{ print $3 }' | sort)
declared=$(grep -o '^BINNACLE_API [^;(]*(' "$2" | sed 's/.*[ *]\(binnacle_[a-z_]*\)($/\1/' | sort)
[ "$(wc -l <<<"$declared")" -ge 50 ] || {
  echo "FAILED: the header's functions are not found"
  exit 1
}
diff <(echo "$declared") <(echo "$exported") || {
  echo "FAILED: < is declared and not exported, > is exported and not declared"
  exit 1
}
soname=$(readelf -d "$1" | sed -n 's/.*SONAME.*\[\(.*\)\].*/\1/p')
major=$(sed -n 's/^#define BINNACLE_INTERFACE_MAJOR \([0-9]*\)$/\1/p' "$2")
[ "$soname" = "libbinnacle_c.so.$major" ] || {
  echo "FAILED: the soname is $soname, the interface $major"
  exit 1
}
