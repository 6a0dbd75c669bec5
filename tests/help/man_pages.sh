#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Each verb has a manual page, with exactly the options of its --help, that groff takes without a warning:
# man_pages.sh COMMAND HELP_FOLDER
set -euo pipefail
command=$1 pages=$2/man
command -v man >/dev/null || {
  echo "SKIPPED: no man (Debian package man-db)"
  exit 77
}
faults=0
fault() {
  printf 'FAILED: %s\n' "$*" >&2
  faults=$((faults + 1))
}

# show PAGE: as on a terminal, without hyphenation, which would cut names of options.
show() { LC_ALL=C.UTF-8 MANWIDTH=200 man --no-hyphenation --no-justification -l "$1"; }
options_in() { { grep -oE -e '--[a-z][a-z-]*' || true; } | sort -u; }

verbs=$("$command" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
[ "$(wc -w <<<"$verbs")" -ge 19 ] || fault "--help lists these verbs alone: $verbs"
for verb in $verbs; do
  page=$pages/binnacle-$verb.1.gz
  if [ ! -e "$page" ]; then
    fault "$verb has no page"
    continue
  fi
  # What begins a line of OPTIONS, and of --help.
  shown=$(show "$page" | sed -n '/^OPTIONS/,/^[A-NP-Z]/p' | grep -E '^ {7}-' | sed 's/^ *\(\(-[-a-z]*,\? \?\)*\).*/\1/' | options_in)
  helped=$("$command" "$verb" --help | grep -E '^ +-' | sed 's/^ *\([-a-z,]*\).*/\1/' | options_in)
  [ "$shown" = "$helped" ] || fault "$verb: the page has the options $(tr '\n' ' ' <<<"$shown")and --help $(tr '\n' ' ' <<<"$helped")"
  name=$(show "$page" | grep -A1 '^NAME' | tail -1)
  [[ $name == *"binnacle-$verb - "* ]] || fault "$verb: apropos will not find '$name'"
done
[ "$(find "$pages" -name '*.gz' | wc -l)" -eq $(($(wc -w <<<"$verbs") + 1)) ] || fault "there are pages of no verb"

for page in "$pages"/*.gz; do
  # As lintian looks at it.
  warnings=$(LC_ALL=C.UTF-8 MANROFFSEQ='' MANWIDTH=80 man --warnings -E UTF-8 -l -Tutf8 -Z "$page" 2>&1 >/dev/null)
  [ -z "$warnings" ] || fault "$page: $warnings"
  LC_ALL=C.UTF-8 lexgrog "$page" >/dev/null || fault "$page has no name that mandb reads"
done
exit $((faults > 0))
