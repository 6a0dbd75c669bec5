#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Installs what sdk/dist/pack made in a clean Debian, and uses it there as a user would: dist.sh KIND SUITE FOLDER
# From installing to the first result no more than 60 s and 80 MB; then a plugin's sources, the conformance suite, a manual page,
# results as NetCDF, Python.
set -euo pipefail
kind=$1 suite=$2 packed=$(realpath -m -- "$3")
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
. "$here/../../sdk/dist/chroot.sh"
limit_s=60 limit_mb=80

skip() {
  echo "SKIPPED: $*"
  exit 77
}
fail() {
  [ ! -e "${log:-}" ] || tail -n 30 "$log" >&2
  printf 'FAILED: %s on %s: %s\n' "$kind" "$suite" "$*" >&2
  exit 1
}

missing=$(chroot_missing "$suite")
[ -z "$missing" ] || skip "$missing"
case $kind in
  deb) pattern='binnacle_*_amd64.deb' before=() ;;
  tarball) pattern='binnacle-*-linux-x86_64.tar.gz' before=() ;;
  wheel) pattern='binnacle-*.whl' before=(man-db python3-numpy python3-venv) ;;
esac
mapfile -t files < <(find "$packed" -maxdepth 1 -name "$pattern" 2>/dev/null)
[ ${#files[@]} -gt 0 ] || skip "there is no $pattern in $packed"
[ ${#files[@]} -eq 1 ] || fail "there are several files $pattern in $packed"

folder=$(chroot_new "$suite" "${before[@]}") || fail "no clean system"
log=$(mktemp)
trap 'rm -f -- "$log"; chroot_remove "$folder"' EXIT
mkdir "$folder/packed"
cp "$packed"/binnacle*.* "$packed"/python3-binnacle*.deb "$folder/packed/" 2>/dev/null || true

# do_in COMMAND…: its output goes to the log.
do_in() { in_chroot "$folder" --bind "$folder/packed:/packed" env -C /opt/home PATH="${path:-}/usr/sbin:/usr/bin:/sbin:/bin" "$@" >"$log" 2>&1; }
# Kilobytes on disk, without the lists of packages and what apt has fetched: apt-get clean removes that.
size_kb() { du -sxk --exclude="$folder/packed" --exclude="$folder/var/lib/apt/lists" --exclude="$folder/var/cache/apt" "$folder" | cut -f1; }

# ---- install and run

install_deb() { do_in apt-get -q install -y "/packed/${files[0]##*/}"; }
install_tarball() {
  do_in tar -C /opt -xzf "/packed/${files[0]##*/}" && do_in mv "/opt/$(basename "${files[0]}" .tar.gz)" /opt/moved
}
install_wheel() { do_in venv/bin/pip install --no-index "/packed/${files[0]##*/}"; }
case $kind in
  deb) prefix=/usr path='' && do_in apt-get -q update ;;
  tarball) prefix=/opt/moved path=$prefix/bin: ;;
  wheel) prefix='' path=/opt/home/venv/bin: && do_in python3 -m venv --system-site-packages venv ;;
esac || fail "nothing can be installed"

size=$(size_kb) begin=$(date +%s.%N)
"install_$kind" || fail "it does not install"
if [ "$kind" = wheel ]; then
  do_in python3 -c 'import binnacle, os; print(os.path.dirname(binnacle.__file__))' || fail "import binnacle"
  prefix=$(tail -n 1 "$log")
fi
quickstart=$prefix/share/binnacle/configs/quickstart.json
do_in binnacle run "$quickstart" || fail "the quickstart does not run"
grep -q '^verdict: ins ok' "$log" || fail "the quickstart's verdict"
took=$(awk -v a="$begin" -v b="$(date +%s.%N)" 'BEGIN { printf "%.1f", b - a }')
grown=$(awk -v a="$size" -v b="$(size_kb)" 'BEGIN { printf "%.1f", (b - a) * 1024 / 1e6 }')
echo "$kind on $suite: installed and run in $took s; $grown MB on disk"
awk -v a="$took" -v b="$limit_s" 'BEGIN { exit a > b }' || fail "it took $took s, of which $limit_s are allowed"
awk -v a="$grown" -v b="$limit_mb" 'BEGIN { exit a > b }' || fail "it takes $grown MB, of which $limit_mb are allowed"

# ---- what else a user does first

do_in binnacle new plugin my_range && [ -s "$folder/opt/home/my_range/plugin.cpp" ] || fail "new plugin"
[ "$kind" = deb ] || do_in test -e "$prefix/lib/cmake/Binnacle/BinnacleConfig.cmake" || fail "nothing to build a plugin with"
do_in binnacle conform "$prefix/lib/binnacle/gnss_fix.so" --level 2 || fail "conform"

[ "$kind" = wheel ] || chroot_install "$folder" man-db >"$log" 2>&1 || fail "man-db does not install"
manual=()
[ "$kind" != tarball ] || manual=(-M "$prefix/share/man")
do_in man -P cat "${manual[@]}" binnacle-run || fail "man binnacle-run"
grep -q 'binnacle run \[OPTION\]... CONFIG' "$log" || fail "man binnacle-run shows something else"

if [ "$kind" = deb ]; then
  # Without NetCDF the command names the package that is missing; with it the command writes.
  ! do_in binnacle run "$quickstart" --out /opt/home/out || fail "results were written without NetCDF"
  package=$(sed -n 's/.*install the Debian package \([a-z0-9]*\).*/\1/p' "$log" | head -n 1)
  [ -n "$package" ] || fail "nothing names the package of NetCDF"
  do_in apt-get -q install -y --no-install-recommends "$package" || fail "$package does not install"
  echo "$kind on $suite: with $package $(awk -v a="$size" -v b="$(size_kb)" 'BEGIN { printf "%.1f", (b - a) * 1024 / 1e6 }') MB, man-db included"
fi
do_in binnacle run "$quickstart" --out /opt/home/out && [ -s "$folder/opt/home/out/run.nc" ] || fail "run --out"
do_in binnacle report /opt/home/out || fail "report of results"

case $kind in
  deb)
    do_in sh -c 'apt-get -q install -y --no-install-recommends /packed/python3-binnacle_*.deb' || fail "python3-binnacle does not install"
    ;;
  tarball) exit 0 ;;
esac
do_in python3 -c "
import binnacle
result = binnacle.load('$quickstart').run(seed=1)
assert result['ins']['position'].shape[1] == 3
print(result.summary)" || fail "Python"
grep -q '^verdict: ins ok' "$log" || fail "Python's verdict"
