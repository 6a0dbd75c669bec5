#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Makes the Debian packages of a build, for the tests that look into them: pack.sh BUILD CPACK FOLDER
set -euo pipefail
build=$1 cpack=$2 folder=$3

rm -rf -- "$folder"
command -v dpkg-shlibdeps >/dev/null || {
  echo "SKIPPED: no dpkg-shlibdeps (Debian package dpkg-dev)"
  exit 77
}
mkdir -p "$folder"
"$cpack" -G DEB --config "$build/CPackConfig.cmake" -B "$folder" >"$folder/log" 2>&1 || {
  cat "$folder/log" >&2
  echo "FAILED: cpack" >&2
  exit 1
}
