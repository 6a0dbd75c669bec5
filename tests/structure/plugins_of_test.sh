#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# sdk/plugins_of.sh finds the plugins that a config needs: with those alone, `check` says of each config what it says with all.
# plugins_of_test.sh PROJECT BUILD SCRATCH
set -euo pipefail
project=$1 build=$2 scratch=$3
unset BINNACLE_PLUGIN_PATH
rm -rf -- "$scratch"
mkdir -p "$scratch/bin" "$scratch/config"
trap 'rm -rf -- "$scratch"' EXIT
cp -l "$build"/bin/binnacle* "$scratch/bin"

failed=0 count=0
fail() {
  printf 'FAILED: %s\n' "$*" >&2
  failed=1
}

# says COMMAND CONFIG: exit status and what it finds wrong; a type that is there in no plugin is wrong.
says() {
  local status=0 text
  text=$("$1" check "$2" 2>&1 >/dev/null) || status=$?
  printf '%s\n%s\n' "$status" "$text"
}

# with_plugins NAME…: the command sees these and no others.
with_plugins() {
  local plugin
  rm -rf -- "${scratch:?}/lib"
  mkdir -p "$scratch/lib/binnacle"
  for plugin; do cp -l "$build/lib/binnacle/$plugin.so" "$scratch/lib/binnacle"; done
}

while IFS= read -r config; do
  mapfile -t plugins < <(bash "$project/sdk/plugins_of.sh" "$config")
  with_plugins "${plugins[@]}"
  few=$(says "$scratch/bin/binnacle" "$config")
  all=$(says "$build/bin/binnacle" "$config")
  [ "$few" = "$all" ] || fail "$config with ${plugins[*]}: $few"
  count=$((count + 1))
done < <(find "$project/configs" -name '*.json' | sort)
[ "$count" -ge 90 ] || fail "only $count configs were tried"

# With a plugin less the quickstart does not compose: the comparison above can fail.
mapfile -t plugins < <(bash "$project/sdk/plugins_of.sh" "$project/configs/quickstart.json")
with_plugins "${plugins[@]:1}"
[ "$(says "$scratch/bin/binnacle" "$project/configs/quickstart.json" | head -n 1)" != 0 ] ||
  fail "the quickstart composes without ${plugins[0]}"
[ "${#plugins[@]}" -le 6 ] || fail "the quickstart gets ${#plugins[@]} plugins: ${plugins[*]}"

# Comments, names of members, files that are named, options, what is no file.
cat >"$scratch/config/base.json" <<'JSON'
{ "sources": { "imu": { "type": "csv" } },  // "type": "huber" is taken, for a comment may be switched off by hand
JSON
cat >"$scratch/config/config.json" <<'JSON'
{
  "extends": ["base.json", "missing.json", "config.json"],
  "range": { "type":
    "ublox" }, "reference": { "columns": ["heading", "lat"] }
}
JSON
expect() {
  local found
  found=$(bash "$project/sdk/plugins_of.sh" "${@:2}" | tr '\n' ' ')
  [ "$found" = "$1" ] || fail "plugins of ${*:2}: '$found', not '$1'"
}
# stream has a type csv too.
expect "csv robust stream ublox " "$scratch/config/config.json"
expect "csv robust rtklib stream ublox " "$scratch/config/config.json" --set /sources/imu/type=rtklib_pos
expect "robust " "$scratch/config/nothing.json" --var model=robust/cauchy
expect "" "$scratch/config/nothing.json"
[ "$failed" = 0 ] && echo "$count configs"
exit "$failed"
