#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The site of the project is whole: built.sh PROJECT SITE PYTHON REFERENCE
set -euo pipefail
project=$1 site=$2 python=$3 reference=$4
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
. "$here/common.sh"
need_packages

rm -rf -- "$site"
"$project/sdk/site/build" --reference "$reference" "$site"
[ -e "$site/sdk/docs/reference.html" ] || { echo "the reference is no page" && exit 1; }
mapfile -t headers < <(cd "$project" && {
  (cd kernel/include && ls binnacle/*.hpp)
  (cd sdk/testing/include && ls binnacle/*.hpp)
  (cd sdk/c/include && ls -- *.h)
})
[ ${#headers[@]} -gt 30 ] || { echo "only ${#headers[@]} headers" && exit 1; }
"$python" "$here/links.py" "$site" "${headers[@]}"
