# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Packages and build, shared by sdk/run and tests/run; sourced, not run. Prints on stderr only.

binnacle_root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
use_preset() { binnacle_preset=$1 binnacle_build=$binnacle_root/build/$1; }  # of CMakePresets.json
use_preset release
binnacle_jobs=$(nproc 2>/dev/null || echo 2)

say() { printf 'binnacle: %s\n' "$*" >&2; }

# shellcheck source=sdk/progress.sh
. "$binnacle_root/sdk/progress.sh"

# listed_packages SECTION…: of sdk/packages.txt.
listed_packages() {
  awk -v sections=" $* " '{ sub(/#.*/, "") } NF == 2 && sub(/:$/, "", $1) && index(sections, " " $1 " ") { print $2 }' \
    "$binnacle_root/sdk/packages.txt"
}

missing_packages() {
  local installed
  # dpkg-query fails when one of them is unknown to it.
  # shellcheck disable=SC2046  # one word a package
  installed=$({ dpkg-query -W -f '${db:Status-Status} ${Package}\n' $(listed_packages "$@") 2>/dev/null || true; } |
    sed -n 's/^installed //p')
  listed_packages "$@" | grep -vxF -e "${installed:-none}" || true
}

# run_logged LOG COMMAND…: its output goes to LOG, and to stderr too when it fails.
run_logged() {
  local log=$1
  shift
  mkdir -p "$(dirname "$log")"
  if "$@" >"$log" 2>&1 </dev/null; then return 0; fi
  cat "$log" >&2
  say "failed: $1 (the log above is $log)"
  return 1
}

apt() {
  local attempt
  for attempt in 1 2 3; do
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get -q -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" && return 0
    [ "$attempt" = 3 ] || sleep 5
  done
  return 1
}

apt_update_and_install() { apt update && apt install -y --no-install-recommends "$@"; }

# install_packages SECTION…: installs what is missing of these sections of packages.txt. Exit status 2, with the line to
# type, if it has no right to.
install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    say "this is no Debian: install by hand what sdk/packages.txt lists in the sections $*"
    return 0
  fi
  local missing as_root begin=$SECONDS
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -gt 0 ] || return 0

  if [ "$(id -u)" = 0 ]; then
    as_root=()
  elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root=(sudo -n)
  else
    local become="su - -c"  # - for a PATH with sbin, which dpkg wants
    command -v sudo >/dev/null && become="sudo sh -c"
    say "${#missing[@]} Debian packages are missing. Please type this line, then try again:"
    printf "%s 'apt-get update && apt-get install -y --no-install-recommends %s'\n" "$become" "${missing[*]}" >&2
    exit 2
  fi
  say "installing ${#missing[@]} Debian packages, about $(((30 + 4 * ${#missing[@]} + 59) / 60)) min: ${missing[*]}"
  run_logged "$binnacle_root/build/install.log" apt_update_and_install "${missing[@]}" || return 1
  say "installed in $((SECONDS - begin)) s"
}

# The steps that ninja would do, into plan.txt. `ninja -n` stops where folders are to be looked through again, so that is done first,
# and left out of what is planned.
plan_targets() {
  ninja -C "$binnacle_build" build.ninja >"$binnacle_build/configure.log" 2>&1 </dev/null || return 0
  awk '/^build build\.ninja:/ { skip = 1 } /^$/ { skip = 0 } !skip' "$binnacle_build/build.ninja" >"$binnacle_build/plan.ninja"
  ninja -C "$binnacle_build" -f plan.ninja -n "$@" 2>/dev/null </dev/null || true
}

ninja_targets() {
  local log=$binnacle_build/build.log
  plan_targets "$@" >"$binnacle_build/plan.txt"
  # A fault of the display does not end the build.
  if NINJA_STATUS='[%f/%t] ' ninja -C "$binnacle_build" -j"$binnacle_jobs" "$@" 2>&1 </dev/null | tee "$log" |
    { (show_progress "$binnacle_build/plan.txt") || cat >/dev/null; }; then
    return 0
  fi
  cat "$log" >&2
  say "the build failed (the log above is $log)"
  return 1
}

configure() { (cd -- "$binnacle_root" && cmake --preset "$binnacle_preset" "$@"); }

# Targets that the last configuration left out because packages were missing then; one a line (sdk/cmake/BinnacleLacking.cmake).
left_out() { cat "$binnacle_build/left_out.txt" 2>/dev/null; }

# knows TARGET: the build folder is configured and has it.
knows() { grep -qE "^build $1(: | \|)" "$binnacle_build/build.ninja" 2>/dev/null; }

# build TARGETS -- [CMAKE OPTIONS]: configures when it must, builds the targets. One build of a preset at a time.
# A target with a ? behind its name may be missing. With binnacle_again=1 what was left out is looked for again.
build() {
  local targets=() wanted=() target
  while [ $# -gt 0 ] && [ "$1" != -- ]; do
    wanted+=("$1")
    shift
  done
  [ $# -eq 0 ] || shift
  mkdir -p "$binnacle_build"
  (
    set -o pipefail  # whoever sources this may not have it
    flock 9
    if [ ! -e "$binnacle_build/build.ninja" ] || [ $# -gt 0 ] || { [ -n "${binnacle_again:-}" ] && [ -n "$(left_out)" ]; }; then
      say "configuring (some seconds)"
      run_logged "$binnacle_build/configure.log" configure "$@" || exit 1
    fi
    for target in "${wanted[@]}"; do
      case $target in
        *\?) ! knows "${target%\?}" || targets+=("${target%\?}") ;;
        *) targets+=("$target") ;;
      esac
    done
    ninja_targets "${targets[@]}"
  ) 9>"$binnacle_build/.lock"
}
