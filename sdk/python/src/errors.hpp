// SPDX-License-Identifier: Apache-2.0
// Errors of Binnacle as exceptions of the package, with their diagnostics.
#pragma once

#include "binnacle/diagnostic.hpp"
#include "convert.hpp"

namespace binnacle::python {

/// A list of binnacle.Diagnostic, in the order of file, line and column.
py::list to_python(const Diagnostics& diagnostics);

/// Sets Python's exception to the one of its kind.
void raise(const Error& error);

/// Every binnacle::Error that leaves a call becomes the exception of its kind: ConfigError, LoadError, DataError, FilterError.
void bind_errors(py::module_& module);

}  // namespace binnacle::python
