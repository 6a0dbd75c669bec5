# SPDX-License-Identifier: Apache-2.0
"""Completion for zsh, from what --help prints."""
from help_text import action_of

SCRIPT = r"""#compdef binnacle
# SPDX-License-Identifier: Apache-2.0
# Completion of binnacle for zsh. Made from --help by sdk/help/zsh_completion.py: do not edit.

# Component types, as plugin/type and by their short names.
_binnacle_types() {
  local -a types
  types=(${${(M)${(f)"$(_call_program types ${(q)words_of_command[1]} list 2>/dev/null)"}:#  [a-z]*/*}##  })
  types=(${types%% *})
  compadd -a types
  compadd -- ${types#*/}
}

_binnacle() {
  local context state state_descr line
  local -a words_of_command=("${words[@]}")
  typeset -A opt_args
  _arguments -C '(- *)'{-h,--help}'[Print this help message and exit]' '1:verb:->verb' '*::argument:->argument'
  case $state in
    verb)
      local -a verbs=(
@VERBS@
      )
      _describe verb verbs ;;
    argument)
      case $line[1] in
@CASES@
      esac ;;
  esac
}

_binnacle "$@"
"""

ACTIONS = {
    "config": '_files -g "*.json(-.)"',
    "library": '_files -g "*.so(-.)"',
    "directory": "_files -/",
    "file": "_files",
    "type": "_binnacle_types",
    "none": "",
}


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def escaped(text, signs):
    return "".join("\\" + sign if sign in signs else sign for sign in text)


def value_of(entry):
    kind = action_of(entry)
    action = f"({' '.join(entry.choices)})" if kind == "choice" else ACTIONS[kind]
    return f":{escaped(entry.value, ':')}:{action}"


def option_specs(entry):
    text = escaped(entry.text, "[]:\\")
    for name in entry.names:
        if name in ("-h", "--help"):
            yield quoted(f"(- *){name}[{text}]")
            continue
        sign = ("=" if name.startswith("--") else "+") if entry.value else ""
        exclusion = "*" if entry.repeated else f"({' '.join(entry.names + entry.excludes)})"
        yield quoted(f"{exclusion}{name}{sign}[{text}]{value_of(entry) if entry.value else ''}")


def positional_spec(number, entry):
    return quoted(("*" if entry.repeated else str(number)) + value_of(entry))


def script(verbs):
    names = "\n".join(f"        {quoted(verb.name + ':' + escaped(verb.summary, ':'))}" for verb in verbs)
    cases = []
    for verb in verbs:
        specs = [spec for entry in verb.options for spec in option_specs(entry)]
        specs += [positional_spec(number, entry) for number, entry in enumerate(verb.positionals, 1)]
        cases.append(f"        {verb.name})\n          _arguments -s \\\n            " + " \\\n            ".join(specs) + " ;;")
    return SCRIPT.replace("@VERBS@", names).replace("@CASES@", "\n".join(cases))
