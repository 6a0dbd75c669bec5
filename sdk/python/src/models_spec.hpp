// SPDX-License-Identifier: Apache-2.0
// Specs of models in Python: parameters, ports and fields as Python writes them.
#pragma once

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "convert.hpp"

namespace binnacle::python {

/// Of the attribute `spec` of a class. Throws py::type_error for a member of another type than it should be.
ComponentSpec spec_of(const std::string& type, const py::object& spec);

/// Checked parameters by name, those that are absent left out: numbers, numpy arrays, texts, lists, dicts; times in seconds.
py::dict to_python(const Parameters& parameters, const std::vector<ParameterSpec>& specs);

/// float64, of its own memory, which may be written.
py::array_t<double> copy_of(const double* numbers, py::ssize_t count);
/// (rows, columns) of column-major numbers.
py::array_t<double> copy_of(const double* numbers, int rows, int columns, int stride);
/// The array may be read and no longer written.
py::array_t<double> sealed(py::array_t<double> array);

}  // namespace binnacle::python
