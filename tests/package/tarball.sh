#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The tarball of the source configures and builds without a network: tarball.sh SOURCE CMAKE VERSION
# It builds one plugin, for which the generated headers have to be there, and runs nothing.
set -euo pipefail
source=$1 cmake=$2 version=$3
if [ ! -e "$source/.git" ] || ! command -v git >/dev/null; then
  echo "SKIPPED: no git checkout, of which a tarball is made"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  [ ! -e "$scratch/log" ] || tail -n 30 "$scratch/log" >&2
  exit 1
}

tarball=$(bash "$source/sdk/dist/source" "$version" "$scratch" 2>/dev/null)
[ "$tarball" = "$scratch/binnacle-$version.tar.gz" ] || fail "sdk/dist/source prints: $tarball"
bash "$source/sdk/dist/source" "$version" "$scratch/again" >/dev/null 2>&1
cmp "$tarball" "$scratch/again/binnacle-$version.tar.gz" || fail "twice the same commit is not twice the same tarball"
tar -xzf "$tarball" -C "$scratch"
unpacked=$scratch/binnacle-$version
[ ! -e "$unpacked/.git" ] || fail "the tarball has the history"

offline=()
for form in "unshare -n" "unshare -rn"; do
  read -ra words <<<"$form"
  if "${words[@]}" true 2>/dev/null; then
    offline=("${words[@]}")
    break
  fi
done
[ ${#offline[@]} -gt 0 ] || echo "note: no network namespaces here: the network stays reachable"
# As sdk/docs/install.md says, but for the one target.
cd "$unpacked"
"${offline[@]}" "$cmake" --preset release -DBUILD_TESTING=OFF >"$scratch/log" 2>&1 || fail "cmake --preset release"
"${offline[@]}" "$cmake" --build build/release --target gnss_fix_plugin >"$scratch/log" 2>&1 || fail "cmake --build"
[ -s build/release/lib/binnacle/gnss_fix.so ] || fail "no plugin is built"

# From the unpacked source no tarball is made, and it says so.
if bash "$unpacked/sdk/dist/source" "$version" "$scratch/third" 2>"$scratch/log"; then fail "a tarball of no commit"; fi
grep -q 'is no git checkout' "$scratch/log" || fail "sdk/dist/source does not say why there is no tarball"
