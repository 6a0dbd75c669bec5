// SPDX-License-Identifier: Apache-2.0
// Roles that checks apply to.
#pragma once

#include <iterator>
#include <vector>

#include "binnacle/catalog.hpp"

namespace binnacle::conform {

inline const std::vector<Role> every_role(std::begin(all_roles), std::end(all_roles));
inline const std::vector<Role> called_roles = {Role::state_block,   Role::process_model,   Role::measurement_model,
                                               Role::derived_block, Role::noise_estimator, Role::source,
                                               Role::transform};

}  // namespace binnacle::conform
