// SPDX-License-Identifier: Apache-2.0
// Derived blocks: their values, and their Jacobians chained to the state blocks.
#pragma once

#include <vector>

#include "filter/model_calls.hpp"
#include "filter/workspace.hpp"

namespace binnacle::filter {

/// Evaluates the values, given in order of dependence, into the workspace; ends with the first refusal.
Result evaluate_derived(const FilterPlan& plan, const std::vector<int>& values, const Moment& now, Workspace& workspace,
                        ModelCalls& calls);

}  // namespace binnacle::filter
