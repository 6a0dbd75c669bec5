# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# What the tests of the site share; sourced, not run.

# Ends the test as skipped, in CI as failed, without the packages that are marked `site:`.
need_packages() {
  local package missing=()
  for package in mkdocs mkdocs-material doxygen aspell aspell-en; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  echo "SKIPPED: no ${missing[*]} (Debian packages)"
  [ "${CI:-}" = true ] && exit 1
  exit 77
}

# refused WORDS COMMAND…: it fails, and with these words.
refused() {
  local words=$1 log
  shift
  if log=$("$@" 2>&1); then
    printf 'FAILED: accepted, with no "%s": %s\n%s\n' "$words" "$*" "$log" >&2
    exit 1
  fi
  [[ $log == *"$words"* ]] || {
    printf 'FAILED: no "%s" in:\n%s\n' "$words" "$log" >&2
    exit 1
  }
}
