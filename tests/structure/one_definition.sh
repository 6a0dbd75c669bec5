#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# `one_definition.sh SCRATCH COMPILER FOLDER -- FLAGS…`: the .cpp files under FOLDER, compiled for link-time optimization
# and read together, define each type once. Only GCC checks that.
set -euo pipefail

scratch=$1 compiler=$2 folder=$3
shift 4
mkdir -p "$scratch"
rm -f "$scratch"/*.o

launcher=()
if command -v ccache >/dev/null; then launcher=(ccache); fi
flags=("$@" -std=c++20 -O0 -flto -fPIC -w -c)
number=0
while IFS= read -r file; do
  number=$((number + 1))
  printf '%s\0%s\0' "$file" "$scratch/$number.o"
done < <(find "$folder" -name '*.cpp' | sort) |
  xargs -0 -n 2 -P "$(nproc)" bash -c '"${@:1:$#-2}" "${@: -2:1}" -o "${@: -1}"' compile \
    "${launcher[@]}" "$compiler" "${flags[@]}"
"$compiler" -O0 -flto -Wodr -Werror=odr -r -nostdlib -flinker-output=nolto-rel "$scratch"/*.o -o "$scratch/all.obj"
