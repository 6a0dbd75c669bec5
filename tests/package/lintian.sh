#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Debian's own check of the packages finds neither an error nor a warning; sdk/cmake/debian/overrides has what stays, with
# reasons: lintian.sh FOLDER
set -euo pipefail
folder=$1

command -v lintian >/dev/null || {
  echo "SKIPPED: no lintian (Debian package lintian)"
  exit 77
}
ls "$folder"/*.deb >/dev/null 2>&1 || {
  echo "SKIPPED: no packages were made"
  exit 77
}
export LC_ALL=C.UTF-8
lintian --allow-root --no-cfg --fail-on error,warning "$folder"/*.deb

# It looks at all: a package without a copyright is refused.
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
packages=("$folder"/binnacle-dev_*.deb)
mkdir "$scratch/package"
dpkg-deb -e "${packages[0]}" "$scratch/package/DEBIAN"
dpkg-deb --root-owner-group -Znone -b "$scratch/package" "$scratch/bad.deb" >/dev/null
if found=$(lintian --allow-root --no-cfg --fail-on error,warning "$scratch/bad.deb"); then
  echo "FAILED: a package without a copyright passes" >&2
  exit 1
fi
[[ $found == *"E: binnacle-dev: no-copyright-file"* ]] || {
  printf 'FAILED: of a package without a copyright it says: %s\n' "$found" >&2
  exit 1
}
