#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What Debian wants to know of a package's history: changelogs.sh CHANGELOG.md RELEASE MAINTAINER FOLDER
# Leaves FOLDER/changelog.gz, the CHANGELOG, and FOLDER/changelog.Debian.gz, one entry for each version that it has.
set -eu
changelog=$1 release=$2 maintainer=$3 folder=$4
mkdir -p "$folder"
gzip -9nc "$changelog" >"$folder/changelog.gz"

# "## 0.2.0 (2026-11-26)" begins a version. What is not released has none.
sed -n 's/^## \([0-9][0-9.]*\) (\([0-9-]*\))$/\1 \2/p' "$changelog" >"$folder/versions"
[ -s "$folder/versions" ] || {
  echo "changelogs.sh: $changelog has no line such as '## 0.2.0 (2026-11-26)'" >&2
  exit 1
}
while read -r version day; do
  printf 'binnacle (%s-%s) unstable; urgency=medium\n\n' "$version" "$release"
  printf '  * Version %s. changelog.gz has what is new, and what breaks.\n\n' "$version"
  printf ' -- %s  %s\n\n' "$maintainer" "$(LC_ALL=C TZ=UTC date -d "$day" -R)"
done <"$folder/versions" | gzip -9nc >"$folder/changelog.Debian.gz"
rm "$folder/versions"
