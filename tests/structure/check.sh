#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The rules of the house that a compiler does not keep. `check.sh RULE ROOT` reads the sources under ROOT,
# `check.sh libraries FILE…` built plugins. One line an offence, `path:line: what`; exit status 1 if there is one.
set -euo pipefail
export LC_ALL=C

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
rule=$1
shift

sources=(--include='*.cpp' --include='*.hpp' --include='*.h' --include='*.inc')
not_ours=(--exclude-dir=build --exclude-dir=.git --exclude-dir=.cache --exclude=.git --exclude=LICENSE)

# Who includes whom: plugins → kernel/include ← sdk; in kernel/src each folder only those before it.
includes() {
  awk -f "$here/includes.awk" \
    <(find kernel plugins sdk -type f \( -name '*.hpp' -o -name '*.h' -o -name '*.inc' -o -name '*.cpp' \) 2>/dev/null) \
    <(grep -rnE "${sources[@]}" '^[[:space:]]*#[[:space:]]*include' kernel plugins sdk 2>/dev/null)
}

# A plugin is handed all it needs through the headers; linking the kernel would give it a second copy of it.
links() {
  grep -rnE --include=CMakeLists.txt --include='*.cmake' '(Binnacle::|binnacle_)kernel' plugins |
    sed 's/^\([^:]*:[0-9]*\):.*/\1: a plugin links the kernel library/'
}

# The kernel owns all state.
state() {
  find plugins -type f \( -name '*.cpp' -o -name '*.hpp' -o -name '*.h' -o -name '*.inc' \) -print0 |
    xargs -0r awk -f "$here/state.awk"
}

# The kernel composes and runs. What judges runs, what is made of them and what components are about are no words of it.
kernel_words() {
  {
    grep -rnIwiE "${sources[@]}" 'stud(y|ies)|attitude|implied_states?|metrics?|random_constant|strapdown' kernel/src || true
    grep -rnIE "${sources[@]}" '"vector"|vector:[0-9*]|"/(covariance|reference|evaluate|record|metrics)' kernel/src || true
  } | sort -u | sed 's/^\([^:]*:[0-9]*\):\(.*\)/\1: no word of the kernel:\2/'
}

words() {
  {
    grep -rnIwE "${not_ours[@]}" 'TOD[O]|FIXM[E]|XX[X]|HAC[K]' . || true
    grep -rnIwiE "${not_ours[@]}" 'stu[b]|placeholde[r]|not implemente[d]' . || true
  } | sed 's/^\.\/\([^:]*:[0-9]*\):\(.*\)/\1: unfinished:\2/'
}

# A path of one machine. Not one of several after a / or in ${TMPDIR:-…}.
paths() {
  grep -rnIE "${not_ours[@]}" '(^|[^A-Za-z0-9_.})~*/-])/(work|tmp|root|home)(/|[^A-Za-z0-9_/-]|$)' . |
    sed 's/^\.\/\([^:]*:[0-9]*\):\(.*\)/\1: a path of one machine:\2/'
}

license() {
  find . \( -name build -o -name .git -o -name .cache -o -path ./tests/structure/bad/license \) -prune -o -type f \
    \( -name '*.cpp' -o -name '*.hpp' -o -name '*.cmake' -o -name CMakeLists.txt -o -name '*.sh' -o -name run \) -print0 |
    xargs -0r awk '
      BEGIN { for (i = 1; i < ARGC; i++) lacks[ARGV[i]] }
      /SPDX-License-Identifier: Apache-2[.]0/ { delete lacks[FILENAME] }
      FNR == 2 { nextfile }
      END { for (file in lacks) print substr(file, 3) ":1: the licence line is missing" }' | sort
}

# The layout is that of one version of clang-format; another one would find fault with what this one made.
formatter=clang-format-14
command -v $formatter >/dev/null || formatter=clang-format

format() {
  find . \( -name build -o -name .git -o -name .cache -o -path ./tests/structure/bad \) -prune -o -type f \
    \( -name '*.cpp' -o -name '*.hpp' -o -name '*.h' -o -name '*.inc' \) -print0 |
    xargs -0r -n 50 $formatter --style="file:$here/../../.clang-format" --dry-run 2>&1 |
    sed -n 's/^\(\.\/\)\?\([^:]*:[0-9]*\):[0-9]*: warning: .*/\2: not as clang-format lays it out/p' | sort -u
}

# CMake takes a semicolon in a test's name for the end of it: ctest then runs two tests that do not exist.
test_names() {
  grep -rnE "${sources[@]}" 'TEST_CASE(_[A-Z_]+)?\([^"]*"[^"]*;' tests | sed 's/^\([^:]*:[0-9]*\):.*/\1: a semicolon in the name of a test/'
}

# Tests are compiled in batches of files: each stands in the namespace of its name, where nothing clashes. No macros.
own_namespace() {
  find tests -mindepth 2 -maxdepth 2 -name '*_test.cpp' -print0 | sort -z | xargs -0r awk '
    function end() { if (file != "" && !seen) print file ":1: it has no namespace " name }
    FNR == 1 { end(); file = name = FILENAME; gsub(/.*\/|[.]cpp$/, "", name); inside = seen = 0 }
    $0 == "namespace " name " {" { inside = seen = 1; next }
    $0 == "}  // namespace " name { inside = 0; next }
    /^[[:space:]]*#[[:space:]]*(define|undef)/ { print file ":" FNR ": a macro, which the next file of the batch would see"; next }
    !inside && !/^($|\/\/|#)/ { print file ":" FNR ": outside of namespace " name }
    END { end() }'
}

vocabulary() { python3 "$here/vocabulary.py" . | grep -E '^[^:]+:[0-9]+: '; }

# Writable objects that are no state of the plugin's: what crt files bring, pointers to exception types, guards of
# constants made at first use, what <iostream> (which Boost.Random includes) leaves in every file, and the table of
# cache sizes that Eigen's products keep; clang puts Eigen's empty constants there too (Eigen::all, last, lastp1).
not_state='^(completed\.0|__dso_handle|__TMC_END__|_edata|__bss_start|_end|DW\.ref\..*|_ZGV.*|_ZStL8__ioinit|'
not_state+='_ZZN5Eigen8internal20manage_caching_sizes.*|_ZN5EigenL(3all|4last|6lastp1)E|)$'

libraries() {
  local file exported
  [ $# -gt 0 ] || echo "no library was given"
  for file in "$@"; do
    exported=$(nm -D --defined-only --format=posix "$file" | cut -d' ' -f1 | sort | paste -sd' ')
    [ "$exported" = "binnacle_guard_v1 binnacle_register_v1 binnacle_types_v1" ] || echo "$file:0: exports: $exported"
    case $(stat -c %a "$file") in
      *[2367]) echo "$file:0: anybody may write it" ;;
    esac
    [ -n "${SANITIZED:-}" ] || objdump -t "$file" |
      awk -v own="$not_state" -v file="$file" '
        # address, flags, section, size, name: sections only of what is written at run time
        match($0, / \.(data|bss|tdata|tbss)(\.[A-Za-z0-9_.]+)?\t/) && $0 !~ / \.data\.rel\.ro/ && substr($0, 24, 1) != "d" {
          name = $NF
          if (name !~ own && name !~ /^\./) print file ":0: writable state: " name
        }'
  done
}

case $rule in
  libraries) found=$(libraries "$@" || true) ;;
  includes | links | state | kernel_words | words | paths | license | test_names | own_namespace | format | vocabulary)
    if [ "$rule" = format ] && ! $formatter --version 2>/dev/null | grep -q 'version 14[.]'; then
      echo "SKIPPED: no clang-format 14 (Debian package clang-format)"
      if [ "${CI:-}" = true ]; then exit 1; else exit 77; fi
    fi
    cd -- "$1"
    found=$("$rule" || true)
    ;;
  *)
    echo "check.sh: no rule '$rule'" >&2
    exit 2
    ;;
esac

[ -z "$found" ] && exit 0
printf '%s\n' "$found"
exit 1
