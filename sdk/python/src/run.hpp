// SPDX-License-Identifier: Apache-2.0
// run: a config over its data, with what came of it as arrays.
#pragma once

#include "convert.hpp"

namespace binnacle::python {

void bind_run(py::module_& module);

}  // namespace binnacle::python
