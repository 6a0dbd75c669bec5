# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Packages and build, shared by sdk/run and tests/run; sourced, not run. Prints on stderr only.

binnacle_root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
use_preset() { binnacle_preset=$1 binnacle_build=$binnacle_root/build/$1; }  # of CMakePresets.json
use_preset release

say() { printf 'binnacle: %s\n' "$*" >&2; }

# What not all need stands as "SECTION: NAME": clang for its presets, site for the manual as a site and in CI. With
# binnacle_section set, what that one lists and nothing else.
listed_packages() {
  local sections='' all=1
  case $binnacle_preset in clang | fuzz) sections+=' clang: ' ;; esac
  [ "${CI:-}" != true ] || sections+=' site: '
  [ -z "${binnacle_section:-}" ] || { sections=" $binnacle_section: " && all=0; }
  awk -v sections="$sections" -v all="$all" '
    { sub(/#.*/, "") }
    NF == 2 && index(sections, " " $1 " ") { print $2 }
    NF == 1 && all { print $1 }' "$binnacle_root/sdk/packages.txt"
}

missing_packages() {
  local installed
  # dpkg-query fails when one of them is unknown to it.
  # shellcheck disable=SC2046  # one word a package
  installed=$({ dpkg-query -W -f '${db:Status-Status} ${Package}\n' $(listed_packages) 2>/dev/null || true; } |
    sed -n 's/^installed //p')
  listed_packages | grep -vxF -e "${installed:-none}" || true
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

# Installs what is missing of packages.txt. Exit status 2, with the line to type, where it may not.
install_packages() {
  command -v dpkg-query >/dev/null && command -v apt-get >/dev/null || {
    say "this is no Debian: install by hand what sdk/packages.txt lists"
    return 0
  }
  local missing as_root
  mapfile -t missing < <(missing_packages)
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
  say "installing ${#missing[@]} Debian packages: ${missing[*]}"
  run_logged "$binnacle_root/build/install.log" apt_update_and_install "${missing[@]}"
}

# Shows ninja's "[12/140]" as one line that rewrites itself, on a terminal.
show_progress() {
  local line
  if [ ! -t 2 ]; then
    cat >/dev/null
    return
  fi
  while IFS= read -r line; do
    case $line in
      \[*/*\]*) printf '\r\033[Kbinnacle: building %s' "${line%% *}" >&2 ;;
    esac
  done
  printf '\r\033[K' >&2
}

ninja_targets() {
  local log=$binnacle_build/build.log
  if NINJA_STATUS='[%f/%t] ' ninja -C "$binnacle_build" "$@" 2>&1 </dev/null | tee "$log" | show_progress; then
    return 0
  fi
  cat "$log" >&2
  say "the build failed (the log above is $log)"
  return 1
}

configure() { (cd -- "$binnacle_root" && cmake --preset "$binnacle_preset" "$@"); }

# build TARGETS -- [CMAKE OPTIONS]: configures when it must, builds the targets. One build of a preset at a time.
build() {
  local targets=()
  while [ $# -gt 0 ] && [ "$1" != -- ]; do
    targets+=("$1")
    shift
  done
  [ $# -eq 0 ] || shift
  mkdir -p "$binnacle_build"
  (
    set -o pipefail  # whoever sources this may not have it
    flock 9
    if [ ! -e "$binnacle_build/build.ninja" ] || [ $# -gt 0 ]; then
      run_logged "$binnacle_build/configure.log" configure "$@" || exit 1
    fi
    if [ ! -e "$binnacle_build/build.log" ]; then
      say "building (the first time takes some minutes; log: ${binnacle_build#"$PWD"/}/build.log)"
    fi
    ninja_targets "${targets[@]}"
  ) 9>"$binnacle_build/.lock"
}
