#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Lets `import binnacle` in python3 find a build's package: show.sh BUILD/python
# Writes that folder's name into binnacle.pth among the user's own packages. The clone that was run last is the one that is found.
# Prints on stderr what it changed, or what to type where it can change nothing; it never fails.
set -uo pipefail
package=$1

say() { printf 'binnacle: %s\n' "$*" >&2; }
by_hand() {
  say "$1; so that \`import binnacle\` works: export PYTHONPATH=$package"
  exit 0
}

[ -e "$package/binnacle/__init__.py" ] || exit 0
[ -n "${HOME-}" ] || unset HOME
command -v python3 >/dev/null || by_hand "there is no python3 on the PATH"
# A module in C++ is of one version of Python.
suffix=$(python3 -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX"))' 2>/dev/null)
if [ ! -e "$package/binnacle/_core$suffix" ]; then
  say "$(command -v python3) is $(python3 --version 2>&1), for which the package is not built: use /usr/bin/python3, with PYTHONPATH=$package"
  exit 0
fi
folder=$(python3 -m site --user-site 2>/dev/null) ||
  by_hand "$(command -v python3) takes no packages of the user's (a virtual environment, say)"
file=$folder/binnacle.pth
before=$(cat "$file" 2>/dev/null)
[ "$before" != "$package" ] || exit 0
{ mkdir -p "$folder" && printf '%s\n' "$package" >"$file"; } 2>/dev/null || by_hand "cannot write $file"
say "\`import binnacle\` in python3 finds this build by $file${before:+, which was for $before}"
