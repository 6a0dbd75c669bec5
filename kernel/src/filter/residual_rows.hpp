// SPDX-License-Identifier: Apache-2.0
// The groups of a measurement's rows, counted through its parts as UpdateRecord::row_groups tells them.
#pragma once

#include <string>
#include <vector>

#include "filter/plan.hpp"

namespace binnacle::filter {

struct ResidualRows {
  std::string name;                 // of its part, of its model's group, or "part.group"
  std::string kind;                 // the model's own name for such rows; empty where it declares no group
  std::string unit;                 // SI, of its residuals
  const BlockPlan* like = nullptr;  // rows are the error components of this block, or of one of the same kind
};

std::vector<ResidualRows> residual_rows_of(const FilterPlan& filter, const MeasurementPlan& measurement);

}  // namespace binnacle::filter
