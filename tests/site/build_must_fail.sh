#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# sdk/site/build refuses what is not whole, and says where: build_must_fail.sh PROJECT
set -euo pipefail
project=$1
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
. "$here/common.sh"
need_packages
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT

copied() {
  rm -rf -- "$scratch/copy"
  mkdir -p "$scratch/copy/kernel" "$scratch/copy/sdk"
  cp -r -- "$project"/*.md "$project"/LICENSE "$project/configs" "$project/plugins" "$scratch/copy"
  cp -r -- "$project"/kernel/{include,DESIGN.md} "$scratch/copy/kernel"
  cp -r -- "$project"/sdk/{docs,examples,site,testing,c,template,python,packages.txt,setup.sh,progress.sh} "$scratch/copy/sdk"
  mkdir "$scratch/copy/tests"
  cd "$scratch/copy"
}
build() { sdk/site/build "$scratch/site"; }

copied
echo '[nothing](nowhere.md)' >>sdk/docs/tutorial.md
mkdir configs/tutorial/parts
echo '# Parts' >configs/tutorial/parts/NOTES.md
refused "the link to nowhere.md leads nowhere" build
refused "configs/tutorial/parts/NOTES.md:1: sdk/site/mkdocs.yml has no place for this page" build

copied
printf 'namespace binnacle {\nstruct Undescribed {};\n}\n' >>kernel/include/binnacle/time.hpp
refused "binnacle::Undescribed has no doc line" build

copied
printf 'namespace binnacle {\n/// \\nosuchcommand\nstruct Described {};\n}\n' >>kernel/include/binnacle/time.hpp
refused "Found unknown command" build

copied
sed -i '2s,.*,//,' kernel/include/binnacle/time.hpp
refused "binnacle/time.hpp:2: the header says nothing of its subject" build

copied
printf '\ndef load(path):\n    return path\n' >>sdk/python/binnacle/_composition.py
refused "load has no docstring" build

refused "there is no /nowhere/reference.md" sdk/site/build --reference /nowhere/reference.md "$scratch/site"

# A folder with something else in it is left as it is.
mkdir "$scratch/taken"
touch "$scratch/taken/file"
refused "is no site of this command" sdk/site/build "$scratch/taken"
[ -e "$scratch/taken/file" ]

# Without the packages, and without the right to install them: the line to type.
mkdir "$scratch/bin"
printf '#!/bin/sh\nexit 1\n' | tee "$scratch/bin/dpkg-query" >"$scratch/bin/sudo"
printf '#!/bin/sh\necho 1000\n' >"$scratch/bin/id"
chmod +x "$scratch"/bin/*
refused "apt-get install -y --no-install-recommends mkdocs mkdocs-material doxygen aspell aspell-en" \
  env PATH="$scratch/bin:$PATH" sdk/site/build "$scratch/site"
