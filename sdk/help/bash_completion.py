# SPDX-License-Identifier: Apache-2.0
"""Completion for bash, from what --help prints. The script needs nothing but bash: no functions of bash-completion."""
from help_text import action_of

SCRIPT = r"""# SPDX-License-Identifier: Apache-2.0
# Completion of binnacle for bash. Made from --help by sdk/help/bash_completion.py: do not edit.

# _binnacle_offer KIND WORD [CHOICES]: COMPREPLY is what WORD may become.
_binnacle_offer() {
  local found
  case $1 in
    config) compopt -o filenames 2>/dev/null
      found=$(compgen -f -X '!*.json' -- "$2"; compgen -d -- "$2") ;;
    library) compopt -o filenames 2>/dev/null
      found=$(compgen -f -X '!*.so' -- "$2"; compgen -d -- "$2") ;;
    directory) compopt -o filenames 2>/dev/null
      found=$(compgen -d -- "$2") ;;
    file) compopt -o filenames 2>/dev/null
      found=$(compgen -f -- "$2") ;;
    type) found=$(compgen -W "$(_binnacle_types "$2")" -- "$2") ;;
    choice) found=$(compgen -W "$3" -- "$2") ;;
    *) found= ;;
  esac
  COMPREPLY=()
  [ -z "$found" ] || mapfile -t COMPREPLY <<<"$found"
}

# _binnacle_types WORD: component types, as plugin/type where WORD has a slash, else by their short names.
_binnacle_types() {
  local line name
  while IFS= read -r line; do
    case $line in
      "  "[a-z]*/*) name=${line#  } name=${name%% *}
        case $1 in */*) printf '%s\n' "$name" ;; *) printf '%s\n' "${name#*/}" ;; esac ;;
    esac
  done < <("${COMP_WORDS[0]/#\~/$HOME}" list 2>/dev/null)
}

# _binnacle_value VERB OPTION: kind, and choices, of the option's value; fails where it takes none.
_binnacle_value() {
  case "$1 $2" in
@VALUES@
    *) return 1 ;;
  esac
}

# _binnacle_positional VERB NUMBER: the same of the verb's positional arguments.
_binnacle_positional() {
  case "$1 $2" in
@POSITIONALS@
    *) echo none ;;
  esac
}

_binnacle_options() {
  case $1 in
@OPTIONS@
  esac
}

_binnacle() {
  local -a words=("${COMP_WORDS[@]:1:COMP_CWORD-1}")
  local current=${COMP_WORDS[COMP_CWORD]} verb=${words[0]-} kind choices word
  COMPREPLY=()
  # bash takes --out=DIR apart: the sign is a word of its own.
  [ "$current" = = ] && words+=("=") current=
  local -i i count=${#words[@]} positional=0
  if [ "$count" -eq 0 ]; then
    _binnacle_offer choice "$current" "@VERBS@ --help"
    return
  fi
  local option=${words[count-1]}
  if [ "$option" = = ] && [ "$count" -ge 3 ]; then
    option=${words[count-2]}
    case $option in -*) ;; *) option=${words[count-3]} ;; esac  # of --var NAME=PATH the path
  fi
  if read -r kind choices < <(_binnacle_value "$verb" "$option"); then
    _binnacle_offer "$kind" "$current" "$choices"
    return
  fi
  if [[ $current == -* ]]; then
    _binnacle_offer choice "$current" "$(_binnacle_options "$verb")"
    return
  fi
  for ((i = 1; i < count; i++)); do
    word=${words[i]}
    if [ "$word" = = ]; then
      i+=1
    elif [[ $word != -* ]]; then
      positional+=1
    elif [ "${words[i+1]-}" != = ] && _binnacle_value "$verb" "$word" >/dev/null; then
      i+=1
    fi
  done
  read -r kind choices < <(_binnacle_positional "$verb" "$positional")
  _binnacle_offer "$kind" "$current" "$choices"
}

complete -F _binnacle binnacle
"""


def answer(entry):
    kind = action_of(entry)
    return f"echo {kind}" if kind != "choice" else "echo '" + " ".join([kind, *entry.choices]) + "'"


def script(verbs):
    values, positionals, options = [], [], []
    for verb in verbs:
        for entry in verb.options:
            if entry.value:
                patterns = " | ".join(f'"{verb.name} {name}"' for name in entry.names)
                values.append(f"    {patterns}) {answer(entry)} ;;")
        for number, entry in enumerate(verb.positionals):
            pattern = f'"{verb.name} "*' if entry.repeated else f'"{verb.name} {number}"'
            positionals.append(f"    {pattern}) {answer(entry)} ;;")
        names = " ".join(name for entry in verb.options for name in entry.names)
        options.append(f"    {verb.name}) echo '{names}' ;;")
    parts = {"VALUES": values, "POSITIONALS": positionals, "OPTIONS": options}
    text = SCRIPT.replace("@VERBS@", " ".join(verb.name for verb in verbs))
    for key, lines in parts.items():
        text = text.replace(f"@{key}@", "\n".join(lines))
    return text
