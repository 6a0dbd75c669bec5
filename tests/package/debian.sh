#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Looks into the Debian packages that pack.sh made: debian.sh BUILD CMAKE VERSION FOLDER
set -euo pipefail
build=$1 cmake=$2 version=$3 packed=$4

ls "$packed"/*.deb >/dev/null 2>&1 || {
  echo "SKIPPED: no packages were made"
  exit 77
}
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

# deb PACKAGE: its file.
deb() { echo "$packed/$1_${version}"_*.deb; }

# holds PACKAGE PATH…
holds() {
  local package=$1 listing path
  listing=$(dpkg-deb -c "$(deb "$package")" | awk '{ print $6 }')
  shift
  for path in "$@"; do
    grep -qxF "./usr/$path" <<<"$listing" || fail "$package lacks /usr/$path"
  done
}
holds binnacle bin/binnacle bin/binnacle-{conform,describe,inspect,report,study} lib/binnacle/core.so lib/binnacle/csv.so lib/libbinnacle_c.so.1 \
  share/binnacle/{LICENSE,README.md,configs/quickstart.json,sdk/docs/README.md,sdk/template/process/plugin.cpp}
holds binnacle-dev include/binnacle.h lib/libbinnacle_c.so include/binnacle/plugin.hpp include/binnacle/header_hash.hpp lib/libbinnacle_kernel.a \
  lib/cmake/Binnacle/BinnacleConfig.cmake lib/cmake/Binnacle/binnacle_plugin.map

# Pages and completion, where they are built.
if [ -e "$build/help/zsh/_binnacle" ]; then
  holds binnacle share/man/man1/binnacle{,-run,-conform,-describe,-inspect,-report,-study}.1.gz share/bash-completion/completions/binnacle \
    share/zsh/vendor-completions/_binnacle
fi

field() { dpkg-deb -f "$(deb "$1")" "$2"; }
[ "$(field binnacle-dev Depends)" = "binnacle (= $version), libeigen3-dev" ] || fail "binnacle-dev depends on $(field binnacle-dev Depends)"
field binnacle Depends | grep -q 'libstdc++6 (>= ' || fail "binnacle depends on $(field binnacle Depends)"
[[ $(field binnacle Suggests) =~ (^|, )libnetcdf[0-9] ]] || fail "binnacle, which loads NetCDF, suggests $(field binnacle Suggests)"
# A small system installs it without those.
[[ ! $(field binnacle Depends) =~ (^|, )(libnetcdf|libhdf5|libcurl|python) ]] || fail "binnacle depends on $(field binnacle Depends)"

packages=(binnacle binnacle-dev)
if [ -e "$build/lib/binnacle/mpi/binnacle_mpi.so" ]; then
  packages+=(binnacle-mpi)
  holds binnacle-mpi lib/binnacle/mpi/binnacle_mpi.so
  [[ $(field binnacle-mpi Depends) == *libopenmpi*"binnacle (= $version)"* || $(field binnacle-mpi Depends) == "binnacle (= $version)"*libopenmpi* ]] ||
    fail "binnacle-mpi depends on $(field binnacle-mpi Depends)"
fi
[[ $(field binnacle Depends) != *libopenmpi* ]] || fail "binnacle alone depends on an MPI"

if ls "$build"/python/binnacle/_core*.so >/dev/null 2>&1; then
  packages+=(python3-binnacle)
  holds python3-binnacle lib/python3/dist-packages/binnacle/{__init__.py,_composition.py,_core.pyi,py.typed}
  listing=$(dpkg-deb -c "$(deb python3-binnacle)")  # whole: grep -q would break the pipe
  grep -q '/dist-packages/binnacle/_core[.]cpython.*[.]so$' <<<"$listing" || fail "python3-binnacle lacks its module"
  for needed in "binnacle (= $version)" 'python3 (>= 3.' 'python3 (<< 3.' python3-numpy; do
    [[ $(field python3-binnacle Depends) == *"$needed"* ]] || fail "python3-binnacle depends on $(field python3-binnacle Depends)"
  done
fi

if [ -e "$(deb binnacle-doc)" ]; then
  packages+=(binnacle-doc)
  holds binnacle-doc share/doc/binnacle/html/index.html share/doc/binnacle/html/search/search_index.json
  [ "$(field binnacle-doc Architecture)" = all ] || fail "binnacle-doc is of one architecture"
fi

for package in "${packages[@]}"; do
  holds "$package" "share/doc/$package/copyright" "share/doc/$package/changelog.gz" "share/doc/$package/changelog.Debian.gz"
  [[ $(field "$package" Maintainer) == ?*" <"?*@?*">" ]] || fail "$package has the maintainer $(field "$package" Maintainer)"
  [[ $(field "$package" Description) == "error-state Kalman filters for INS/GNSS"* ]] || fail "$package is described as $(field "$package" Description)"
done

# The packages hold the same as an installation does.
count() { dpkg-deb -c "$(deb "$1")" | grep -c '^-'; }
"$cmake" --install "$build" --prefix "$scratch/installed" >/dev/null
held=0
for package in "${packages[@]}"; do held=$((held + $(count "$package"))); done
[ "$held" -eq "$(find "$scratch/installed" -type f | wc -l)" ] || fail "something is installed that no package holds"

# Unpacked elsewhere, they work: run, write a plugin, hold one against the contract.
for package in "${packages[@]}"; do
  dpkg-deb -x "$(deb "$package")" "$scratch/unpacked"
done
unpacked=$scratch/unpacked/usr/bin/binnacle
"$unpacked" version >/dev/null || fail "the packaged command does not run"
"$unpacked" conform "$scratch/unpacked/usr/lib/binnacle/gnss_fix.so" --level 2 >/dev/null ||
  fail "the packaged suite does not pass the packaged gnss_fix"
(cd "$scratch" && "$unpacked" new plugin packaged >/dev/null) || fail "the packaged command writes no plugin"

if [ -e "$scratch/unpacked/usr/share/man" ] && command -v man >/dev/null; then
  page=$(MANPATH=$scratch/unpacked/usr/share/man man -P cat binnacle-run) || fail "man binnacle-run"
  [[ $page == *"binnacle run [OPTION]... CONFIG"* ]] || fail "man binnacle-run shows: $page"
fi
changes=$(zcat "$scratch/unpacked/usr/share/doc/binnacle/changelog.Debian.gz")
[ "${changes%%$'\n'*}" = "binnacle ($version) unstable; urgency=medium" ] || fail "the newest of changelog.Debian is: ${changes%%$'\n'*}"

# The Python package runs the packaged configs by the packaged plugins, and prints what the packaged command prints.
if [[ " ${packages[*]} " == *" python3-binnacle "* ]]; then
  cd "$scratch/unpacked/usr/share/binnacle"
  without_times() { sed -e '/ per step$/d' -e '/^wall time /d'; }
  PYTHONPATH=$scratch/unpacked/usr/lib/python3/dist-packages /usr/bin/python3 -B -s -c \
    "import binnacle; print(binnacle.load('configs/quickstart.json').run().summary, end='')" >"$scratch/python" ||
    fail "the packaged Python package does not run"
  "$unpacked" run configs/quickstart.json >"$scratch/command"
  diff <(without_times <"$scratch/python") <(without_times <"$scratch/command") >&2 || fail "Python prints something else than the command"
  grep -q '^verdict: ins ok' "$scratch/python" || fail "Python prints no summary"
fi
