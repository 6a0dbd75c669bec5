# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# How far a build is, and about how long it will still take; sourced by setup.sh.
# A step weighs what sdk/build_costs.txt says of its path or of the nearest folder above it; a source that is not there is as
# dear as the mean.

: "${binnacle_root:?}" "${binnacle_build:?}" "${binnacle_jobs:?}"
declare -A binnacle_costs=()
read_costs() {
  local cost path
  while read -r cost path; do
    case $cost in '' | '#'*) ;; *) binnacle_costs[$path]=$cost ;; esac
  done <"$binnacle_root/sdk/build_costs.txt"
}

# weigh "[1/140] Building CXX object plugins/csv/….o": sets weight.
weigh() {
  local path=${1##* }
  weight=1
  case $1 in
    *" Building "*) weight=${binnacle_costs[.]:-1} ;;
    *" Linking "*) path=link/$path ;;
    *) path=other/$path ;;
  esac
  while true; do
    if [ -n "${binnacle_costs[$path]:-}" ]; then
      weight=${binnacle_costs[$path]}
      return 0
    fi
    case $path in */*) path=${path%/*} ;; *) return 0 ;; esac
  done
}

in_words() {
  if [ "$1" -lt 180 ]; then printf '%d s' $((($1 < 10 ? 10 : $1 + 5) / 10 * 10)); else printf '%d min' $((($1 + 30) / 60)); fi
}

# show_state: of a build, from the variables of show_progress.
show_state() {
  local words left=$((all_weight - done_weight)) steps_left=$((steps - done_steps)) others mean under_way seconds least
  words="building: $done_steps of $steps steps, $((100 * done_weight / all_weight)) %"
  # Before a tenth is done, the time left is a guess.
  if [ $((10 * done_weight)) -ge "$all_weight" ] && [ "$steps_left" -gt 0 ]; then
    # When the last step ended, each other job was in the middle of a step.
    others=$((binnacle_jobs < steps_left ? binnacle_jobs - 1 : steps_left - 1))
    mean=$((left / steps_left)) under_way=$((others * mean / 2))
    [ "$under_way" -lt "$left" ] || under_way=0
    seconds=$((last * (left - under_way) / (done_weight + under_way) - (SECONDS - begin - last)))
    # A step that takes longer than expected leaves what comes after it.
    least=$((last * (left - under_way - mean * 6 / 10) / (done_weight + under_way)))
    words+=", about $(in_words $((seconds > least ? seconds : least))) left"
  fi
  if [ -t 2 ]; then printf '\r\033[Kbinnacle: %s' "$words" >&2; else say "$words"; fi
}

# show_progress PLAN: reads ninja's lines. PLAN is a file with the lines of `ninja -n`. One line that rewrites itself on a
# terminal; elsewhere a line every binnacle_every (20) seconds.
show_progress() {
  local line partial='' weight begin=$SECONDS shown=$SECONDS every=${binnacle_every:-20} status
  local steps=0 done_steps=0 all_weight=0 done_weight=0 last=0  # the second at which a step ended last
  read_costs
  while IFS= read -r line; do
    case $line in \[*/*\]\ *) weigh "$line" && all_weight=$((all_weight + weight)) steps=$((steps + 1)) ;; esac
  done <"$1"
  [ "$all_weight" -gt 0 ] || all_weight=1
  [ "$steps" = 0 ] || say "building $steps steps (log: ${binnacle_build#"$PWD"/}/build.log)"
  [ ! -t 2 ] || every=1
  while true; do
    IFS= read -r -t 1 line && status=0 || status=$?
    partial+=$line
    if [ "$status" = 0 ]; then
      case $partial in
        \[*/*\]\ *)
          weigh "$partial"
          done_weight=$((done_weight + weight)) done_steps=$((done_steps + 1)) last=$((SECONDS - begin))
          # A step that was not foreseen, by a tool that writes what others depend on.
          [ "$done_weight" -le "$all_weight" ] || all_weight=$done_weight
          [ "$done_steps" -le "$steps" ] || steps=$done_steps
          ;;
      esac
      partial=''
    elif [ "$status" -le 128 ]; then
      break
    fi
    [ $((SECONDS - shown)) -lt "$every" ] || [ "$steps" = 0 ] || { show_state && shown=$SECONDS; }
  done
  [ ! -t 2 ] || printf '\r\033[K' >&2
  [ "$steps" = 0 ] || say "built in $(in_words $((SECONDS - begin)))"
}
