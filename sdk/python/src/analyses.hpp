// SPDX-License-Identifier: Apache-2.0
// The command's other verbs: study, covariance, tune, observe, allan, inspect, and run --smooth.
#pragma once

#include "convert.hpp"

namespace binnacle::python {

void bind_analyses(py::module_& module);

}  // namespace binnacle::python
