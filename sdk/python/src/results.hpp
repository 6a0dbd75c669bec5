// SPDX-License-Identifier: Apache-2.0
// Results as dicts of arrays, of a run in memory or of a folder.
#pragma once

#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "convert.hpp"
#include "results/results.hpp"
#include "score/run.hpp"

namespace binnacle::python {

/// Estimates of one filter: a row per record.
struct Records {
  struct Output {
    std::string block, output, unit, display_unit;
  };
  std::string name;
  std::vector<Output> outputs;
  std::vector<score::RecordColumn> others;  // adapted noise, implied states, local coordinates
  std::vector<Time> t;
  std::vector<double> values;  // row by row: outputs, their 1-sigma in the same order, the others

  /// Nothing recorded yet.
  static Records of(const FilterInfo& filter);
  std::size_t columns() const { return 2 * outputs.size() + others.size(); }
};

// What is given moves into the arrays.
py::dict taken(Records&& records);
py::dict taken(results::Error&& error);
py::dict taken(results::Updates&& updates);
py::dict taken(results::StudyResults&& study);

void bind_results(py::module_& module);

}  // namespace binnacle::python
