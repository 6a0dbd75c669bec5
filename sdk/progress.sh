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
  while [ -n "$path" ]; do
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

# take_running: the steps that are under way are taken to be the first of the plan that have not ended, as many as there are jobs.
take_running() {
  local step
  while [ "$first" -lt "$steps" ] && [ -n "${ended[$first]:-}" ]; do first=$((first + 1)); done
  running=()
  for ((step = first; step < steps && ${#running[@]} < binnacle_jobs; ++step)); do
    if [ -z "${ended[$step]:-}" ]; then
      running+=("$step")
      started[step]=${started[$step]:-$last}
    fi
  done
}

# time_left: sets seconds, by handing out the steps that are left to the jobs in turn, at the speed of those that have ended.
time_left() {
  local now=$((SECONDS - begin)) speed effective step job least part free=()
  speed=$((1000 * done_weight / (binnacle_jobs * last)))  # of a job, in thousandths of weight a second
  for _ in 1 2; do  # the second with the speed that the first found
    effective=$((1000 * done_weight))
    for step in "${running[@]}"; do
      part=$(((last - started[step]) * speed)) least=$((900 * weights[step]))
      effective=$((effective + (part < least ? part : least)))
    done
    speed=$((effective / (binnacle_jobs * last)))
    [ "$speed" -gt 0 ] || speed=1
  done
  for step in "${running[@]}"; do
    part=$((1000 * weights[step] / speed - now + started[step])) least=$((100 * weights[step] / speed))
    free+=($((part > least ? part : least)))
  done
  for ((step = running[-1] + 1; step < steps; ++step)); do
    [ -z "${ended[$step]:-}" ] || continue
    job=0
    for ((part = 1; part < ${#free[@]}; ++part)); do [ "${free[$part]}" -ge "${free[$job]}" ] || job=$part; done
    free[job]=$((free[job] + 1000 * weights[step] / speed))
  done
  seconds=0
  for part in "${free[@]}"; do [ "$part" -le "$seconds" ] || seconds=$part; done
}

# show_state: of a build, from the variables of show_progress.
show_state() {
  local words seconds
  words="building: $done_steps of $steps steps, $((100 * done_weight / all_weight)) %"
  # Before a tenth is done, the time left is a guess.
  if [ $((10 * done_weight)) -ge "$all_weight" ] && [ "$last" -gt 0 ] && [ ${#running[@]} -gt 0 ]; then
    time_left
    words+=", about $(in_words "$seconds") left"
  fi
  if [ -t 2 ]; then printf '\r\033[Kbinnacle: %s' "$words" >&2; else say "$words"; fi
}

# show_progress PLAN: reads ninja's lines. PLAN is a file with the lines of `ninja -n`. One line that rewrites itself on a
# terminal; elsewhere a line every binnacle_every (20) seconds.
show_progress() {
  local line partial='' weight step begin=$SECONDS shown=$SECONDS every=${binnacle_every:-20} status
  local steps=0 done_steps=0 all_weight=0 done_weight=0 first=0 last=0  # the second at which a step ended last
  local -a weights=() ended=() started=() running=()
  local -A number=()
  read_costs
  while IFS= read -r line; do
    case $line in
      \[*/*\]\ ?*)
        weigh "$line"
        weights[steps]=$weight number[${line#*\] }]=$steps
        all_weight=$((all_weight + weight)) steps=$((steps + 1))
        ;;
    esac
  done <"$1"
  [ "$steps" = 0 ] || say "building $steps steps (log: ${binnacle_build#"$PWD"/}/build.log)"
  take_running
  [ ! -t 2 ] || every=1
  while true; do
    IFS= read -r -t 1 line && status=0 || status=$?
    partial+=$line
    if [ "$status" = 0 ]; then
      step=''
      case $partial in \[*/*\]\ ?*) step=${number[${partial#*\] }]:-} ;; esac
      if [ -n "$step" ] && [ -z "${ended[$step]:-}" ]; then
        ended[step]=1 last=$((SECONDS - begin))
        done_weight=$((done_weight + weights[step])) done_steps=$((done_steps + 1))
        take_running
      fi
      partial=''
    elif [ "$status" -le 128 ]; then
      break
    fi
    [ $((SECONDS - shown)) -lt "$every" ] || [ "$steps" = 0 ] || { show_state && shown=$SECONDS; }
  done
  [ ! -t 2 ] || printf '\r\033[K' >&2
  [ "$steps" = 0 ] || say "built in $(in_words $((SECONDS - begin)))"
}
