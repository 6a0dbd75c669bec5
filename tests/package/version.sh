#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# CMakeLists.txt has the version; whatever else names it names the same: version.sh SOURCE VERSION
set -euo pipefail
source=$1 version=$2

# stale SOURCE: what names another version, one a line.
stale() {
  local date
  grep -qx "version: ${version//./[.]}" "$1/CITATION.cff" || echo "CITATION.cff: version"
  date=$(sed -n 's/^date-released: "\(.*\)"$/\1/p' "$1/CITATION.cff")
  grep -qxF "## $version ($date)" "$1/CHANGELOG.md" || echo "CHANGELOG.md has no line '## $version ($date)', which is the date of CITATION.cff"
  grep -qF "| ${version%.*}.x | yes |" "$1/SECURITY.md" || echo "SECURITY.md: ${version%.*}.x is not supported"
  grep -qF "binnacle-$version.tar.gz" "$1/sdk/docs/install.md" || echo "sdk/docs/install.md: the tarball"
}
found=$(stale "$source")
[ -z "$found" ] || {
  printf 'FAILED: the version is %s, but\n%s\n' "$version" "$found" >&2
  exit 1
}

# Each of them is looked at.
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
mkdir -p "$scratch/sdk/docs"
touch "$scratch"/{CITATION.cff,CHANGELOG.md,SECURITY.md,sdk/docs/install.md}
[ "$(stale "$scratch" | wc -l)" -eq 4 ] || {
  echo "FAILED: files without a version pass" >&2
  exit 1
}
