#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# sdk/docs/install.md is true: apt accepts the packages, files lie where the page says, and what it says to type removes
# them all: install_page.sh BUILD CMAKE PAGE PACKED
set -euo pipefail
build=$1 cmake=$2 page=$3 packed=$4
unset DESTDIR
umask 022

scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
faults=0
fault() {
  printf 'FAILED: %s\n' "$*" >&2
  faults=$((faults + 1))
}
# says LINE: the page has it as a command.
says() { grep -qxF -- "$1" <(sed 's/ *  # .*//' "$page") || fault "the page does not say: $1"; }

# What apt would do.
if [ -d "$packed" ] && command -v apt-get >/dev/null; then
  cd "$packed"
  for command in 'apt-get install ./binnacle_*.deb' 'apt-get install ./*.deb'; do
    says "$command"
    files=${command##* }
    # shellcheck disable=SC2086  # a pattern
    apt-get -s install $files >"$scratch/log" 2>&1 || fault "$command: $(cat "$scratch/log")"
    grep -q '^Inst binnacle ' "$scratch/log" || fault "$command does not install binnacle"
  done
fi

says 'cmake --install build/release --prefix /usr/local'
"$cmake" --install "$build" --prefix "$scratch/prefix" >"$scratch/log" 2>&1 || fault "cmake --install: $(tail -n 3 "$scratch/log")"
cp "$build/install_manifest.txt" "$scratch/manifest"

# Each path of the table; the completion of zsh lies where its second path says, since the prefix is not /usr.
cd "$scratch/prefix"
# shellcheck disable=SC2016  # backquotes of Markdown
paths=$(sed -n '/^## Where files lie/,/^## /s/^| \(`[^|]*\) |.*/\1/p' "$page" | tr -d '`,')
[ "$(wc -w <<<"$paths")" -ge 15 ] || fault "the page's table of paths is not found: $paths"
# shellcheck disable=SC2086  # words, with patterns
for path in $paths; do
  case $path in
    share/zsh/vendor-completions/*) path=share/zsh/site-functions/_binnacle ;;
    lib/python3/*) compgen -G "$build/python/binnacle/_core*.so" >/dev/null || continue ;;
  esac
  [ -e "$path" ] || fault "an installation lacks $path"
done

# Its first run, and the completion, of that installation.
says 'binnacle run /usr/share/binnacle/configs/quickstart.json'
bin/binnacle run share/binnacle/configs/quickstart.json >"$scratch/log" 2>&1 || fault "binnacle run: $(tail -n 3 "$scratch/log")"
says 'source PREFIX/share/bash-completion/completions/binnacle'
if [ -e share/bash-completion/completions/binnacle ]; then
  # shellcheck source=/dev/null
  (source share/bash-completion/completions/binnacle && complete -p binnacle) >"$scratch/log" 2>&1 || fault "completion: $(cat "$scratch/log")"
fi

says 'apt-get purge binnacle'
says 'xargs rm < build/release/install_manifest.txt'
xargs rm <"$scratch/manifest"
left=$(find "$scratch/prefix" -type f)
[ -z "$left" ] || fault "these files stay: $left"
exit $((faults > 0))
