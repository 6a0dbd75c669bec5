#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Builds and runs a project that has Binnacle inside by add_subdirectory: subdirectory.sh SOURCE FOLDER CMAKE CTEST
# FOLDER is kept, so that only the first time compiles the kernel.
set -euo pipefail
source=$1 folder=$2 cmake=$3 ctest=$4
unset BINNACLE_PLUGIN_PATH CMAKE_PREFIX_PATH CMAKE_BUILD_TYPE

"$cmake" -S "$source/tests/package/subdirectory" -B "$folder" -DBINNACLE_SOURCE="$source" \
  -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0
"$cmake" --build "$folder"
for made in lib/binnacle/core.so; do
  [ -e "$folder/binnacle/$made" ] || { echo "FAILED: there is no $made" >&2 && exit 1; }
done
[ ! -e "$folder/binnacle/bin/binnacle" ] || { echo "FAILED: what nobody asked for was built" >&2 && exit 1; }
"$ctest" --test-dir "$folder" --output-on-failure --no-tests=error
