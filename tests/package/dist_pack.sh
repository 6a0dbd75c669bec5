#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Packs this build as sdk/dist/build packs that of a clean system, for dist.sh: dist_pack.sh SOURCE BUILD FOLDER SUITE
set -euo pipefail
source=$1 build=$2 folder=$3 suite=$4
. "$source/sdk/dist/chroot.sh"

rm -rf -- "$folder"
skip() {
  echo "SKIPPED: $*"
  exit 77
}
missing=$(chroot_missing "$suite")
[ -z "$missing" ] || skip "$missing, where packages would be installed"
for tool in patchelf lintian dpkg-shlibdeps; do
  command -v "$tool" >/dev/null || skip "no $tool (Debian packages of sdk/packages.txt: deb, dist)"
done
compgen -G "$build/python/binnacle/_core*.so" >/dev/null || skip "no Python package is built"

for kind in deb tarball wheel; do
  "$source/sdk/dist/pack" "$kind" "$build" "$folder"
done
# No program or library of the tarball finds anything that is neither carried nor a part of every Debian: carry.py refuses to.
# It does so for one that it does not know.
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
mkdir -p "$scratch/prefix/bin"
echo 'int main(void) { return 0; }' | cc -x c - -o "$scratch/prefix/bin/lost" -Wl,--no-as-needed -lz
cp "$(ldd "$scratch/prefix/bin/lost" | awk '/libz/ { print $3 }')" "$scratch/libnowhere.so.1"
patchelf --set-soname libnowhere.so.1 "$scratch/libnowhere.so.1"
patchelf --replace-needed libz.so.1 libnowhere.so.1 "$scratch/prefix/bin/lost"
netcdf=$(sed -n 's/^NETCDF_LIBRARY:FILEPATH=//p' "$build/CMakeCache.txt")
if python3 -B "$source/sdk/dist/carry.py" "$scratch/prefix" "$netcdf" "$source/sdk/dist/no_urls.c" 2>"$scratch/log"; then
  echo "FAILED: a program that needs a library which is nowhere passes" >&2
  exit 1
fi
grep -q 'needs libnowhere.so.1, which is not installed' "$scratch/log" || {
  cat "$scratch/log" >&2
  exit 1
}
