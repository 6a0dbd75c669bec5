#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Names of the project's plugins that a config needs, found in the sources without a build: plugins_of.sh CONFIG [options of run]
# A plugin is needed if one of its types (BINNACLE_TYPES of plugins/NAME/plugin.cpp) is a text of the config, of a JSON file
# that it names, or of an option: rather one too many than one too few. What no plugin registers needs nothing; what is no
# file neither: the command reports both.
set -euo pipefail
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)

# "TYPE PLUGIN" and "PLUGIN/TYPE PLUGIN".
types() {
  awk '
    FNR == 1 { list = 0; n = split(FILENAME, part, "/"); plugin = part[n - 1] }
    /^BINNACLE_TYPES\(/ { list = 1 }
    list {
      line = $0
      while (match(line, /"[^"]*"/)) {
        count = split(substr(line, RSTART + 1, RLENGTH - 2), type, " ")
        for (i = 1; i <= count; ++i) { print type[i], plugin; print plugin "/" type[i], plugin }
        line = substr(line, RSTART + RLENGTH)
      }
      if (/\);/) list = 0
    }' "$here"/plugins/*/plugin.cpp
}

# Texts of a JSON file that may be types, one a line: values of members, texts at the beginning of a line, those of
# comments too; and names of JSON files wherever they stand.
texts_of() {
  awk '{
    rest = $0; before = ""
    while (match(rest, /"([^"\\]|\\.)*"/)) {
      before = substr(rest, 1, RSTART - 1)
      text = substr(rest, RSTART + 1, RLENGTH - 2)
      first = length(rest) == length($0)
      rest = substr(rest, RSTART + RLENGTH)
      if (rest ~ /^[ \t]*:/) continue
      if (before ~ /:[ \t]*$/ || (first && before ~ /^[ \t]*$/) || text ~ /[.]json(#|$)/) print text
    }
  }' "$1"
}

# Every text of the configs and what they name, and every word of the options.
texts() {
  local -A seen=()
  local -a queue=()
  local argument file text
  for argument in "$@"; do
    if [ -f "$argument" ]; then queue+=("$argument"); elif [[ $argument != *.json || $argument = *=* ]]; then printf '%s\n' "$argument" | tr -c 'A-Za-z0-9_/\n' '\n'; fi
    case $argument in *=*.json) [ ! -f "${argument#*=}" ] || queue+=("${argument#*=}") ;; esac
  done
  while [ ${#queue[@]} -gt 0 ]; do
    file=${queue[0]}
    queue=("${queue[@]:1}")
    if [ -n "${seen[$file]:-}" ] || [ ! -r "$file" ]; then continue; fi
    seen[$file]=1
    while IFS= read -r text; do
      printf '%s\n' "$text"
      case $text in
        /*.json | /*.json\#*) text=${text%%\#*} ;;
        *.json | *.json\#*) text=$(dirname -- "$file")/${text%%\#*} ;;
        *) continue ;;
      esac
      [ ! -f "$text" ] || queue+=("$text")
    done < <(texts_of "$file")
  done
}

awk 'NR == FNR { plugins[$1] = plugins[$1] " " $2; next } $0 in plugins { print plugins[$0] }' <(types) <(texts "$@") |
  tr ' ' '\n' | sed '/^$/d' | sort -u
