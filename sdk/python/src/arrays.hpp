// SPDX-License-Identifier: Apache-2.0
// Arrays as sources: samples that Python gave, under the type numpy/arrays. And as sinks: numpy/keep.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "binnacle/config.hpp"
#include "binnacle/registry.hpp"
#include "convert.hpp"

namespace binnacle::python {

/// Numbers of one channel, as they were given: line by line, a line as many as there are names.
struct ArrayData {
  std::string content;  // a digest of all the rest: equal in every process that has equal data
  std::vector<std::string> names;
  std::vector<Time> times;   // of lines
  std::vector<Time> starts;  // of their intervals, no_time where there is none; empty: not given
  std::vector<double> values;
};

/// Those that some config still holds; null: there are none of this content.
std::shared_ptr<const ArrayData> find_arrays(const std::string& content);

/// Adds the type numpy/arrays, and numpy/keep.
void add_array_types(Registry& registry);

void bind_arrays(py::module_& module);

}  // namespace binnacle::python
