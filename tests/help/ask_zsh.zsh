# SPDX-License-Identifier: Apache-2.0
# Types each line "TEXT|…" of CASES into an interactive zsh, and prints "TEXT|MATCHES": ask_zsh.zsh COMMAND_FOLDER COMPLETIONS CASES
zmodload zsh/zpty
typeset -gx ASKED=$(mktemp) FOLDER=$1 COMPLETIONS=$2

setup='
unsetopt beep
path=($FOLDER $path) fpath=($COMPLETIONS $fpath)
autoload -Uz compinit && compinit -u -D
# Every match is written down on its way.
compadd() {
  local -a found
  local options=" ${@[1,(i)(-|--)]} "
  if [[ $options != *" -"[OAD]* ]]; then
    builtin compadd -O found "$@"
    print -rl -- $found >>$ASKED
  fi
  builtin compadd "$@"
}
ask() { _main_complete; print -r -- END >>$ASKED; }
zle -C ask list-choices ask
bindkey "^T" ask
'
print -r -- $setup >$ASKED.setup
zpty terminal "TERM=xterm zsh -f -i"
zpty -w terminal "source $ASKED.setup; print END >>$ASKED"

# Waits until the terminal has written END.
await() {
  local tries noise
  for tries in {1..500}; do
    zpty -r -t terminal noise
    [[ $(tail -n 1 $ASKED) == END ]] && return
    sleep 0.02
  done
  print -ru2 "zsh does not answer: $1"
  exit 1
}
await setup
while IFS='|' read -r text expected; do
  : >$ASKED
  zpty -w -n terminal $'\x15'"$text"$'\x14'  # an empty line, the text, the widget
  await "$text"
  matches=(${(ou)${(f)"$(grep -v -e '^END$' -e '^$' $ASKED)"}})
  print -r -- "$text|$matches"
done <$3
zpty -d terminal
rm -f $ASKED $ASKED.setup
