// SPDX-License-Identifier: Apache-2.0
// Errors against a reference that are far larger than P says: a note beside the verdict, which no reference decides.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace binnacle::score {

/// `consistency`: of a summary, { name: { "nees_mean", "dof", … } }. A line on the block that is farthest beyond its
/// degrees of freedom, or on the state where no block is; empty where neither is. Errors of one run are correlated, so the
/// limit is that of a single sample: a right filter with a right reference exceeds it with a probability of about 1e-6.
std::string overconfident(const nlohmann::ordered_json& consistency);

}  // namespace binnacle::score
