#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What a reader types into the search is found: search.sh SITE PYTHON
set -euo pipefail
site=$1 python=$2
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
. "$here/common.sh"
need_packages

"$python" "$here/search.py" "$site" "lever arm" sdk/docs/tutorial.html
"$python" "$here/search.py" "$site" "MeasurementModel" api/binnacle/measurement_model.hpp.html
