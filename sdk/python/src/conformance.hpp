// SPDX-License-Identifier: Apache-2.0
// conform: the conformance suite on models in Python.
#pragma once

#include "convert.hpp"

namespace binnacle::python {

void bind_conform(py::module_& module);

}  // namespace binnacle::python
