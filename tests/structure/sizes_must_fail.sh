#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# sizes.py finds what is too long, in each language, and nothing else.
set -euo pipefail

sizes="$(dirname -- "${BASH_SOURCE[0]}")/sizes.py"
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
mkdir -p "$tree/kernel/src" "$tree/sdk"

body() { for ((i = 0; i < $1; ++i)); do echo "  $2"; done; }
{
  echo 'namespace n {'
  echo 'struct Short { Short() : a_{1}, b_(2) {} int a_, b_; };'
  echo 'void long_one(const char* text = "{") {'
  body 59 'call("}");  // {'
  echo '}'
  echo 'void fits() {'
  body 58 'if (x) { y({1, 2}); }'
  echo '}'
  echo 'class Many {'
  for ((k = 0; k < 40; ++k)); do echo "  int f$k() const { return 0; }"; echo; done
  echo '};'
  echo '}'
} >"$tree/kernel/src/cpp.cpp"
body 601 '// a line' >"$tree/kernel/src/file.hpp"
{ echo 'def long_two():'; body 60 'call()'; echo; echo 'def fine():'; body 59 'call()'; } >"$tree/sdk/python.py"
{ echo 'function longThree(a) {'; body 59 'call("}");'; echo '}'; echo 'const fine = () => {'; body 58 'a(/}/);'; echo '};'; } \
  >"$tree/sdk/script.js"

expected='kernel/src/cpp.cpp: long_one: 61 lines
kernel/src/file.hpp: the file: 601 lines
sdk/python.py: long_two: 61 lines
sdk/script.js: longThree: 61 lines'
status=0
found=$(python3 "$sizes" "$tree") || status=$?
[ "$status" = 1 ] || { echo "exit status $status"; exit 1; }
diff <(echo "$expected") <(echo "$found")
python3 "$sizes" "$tree" --kernel 1000
if python3 "$sizes" "$tree" --kernel 100; then exit 1; fi

# cpp.cpp has 166 lines that are code, file.hpp none, and tests do not count.
mkdir "$tree/tests"
cp "$tree/kernel/src/cpp.cpp" "$tree/tests"
python3 "$sizes" "$tree" --cpp 166
if python3 "$sizes" "$tree" --cpp 165; then exit 1; fi
