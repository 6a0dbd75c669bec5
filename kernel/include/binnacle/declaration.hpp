// SPDX-License-Identifier: Apache-2.0
// What the declarations of all models have in common.
#pragma once

namespace binnacle {

/// Where a model's Jacobians come from; `binnacle explain` names the models that leave it to a machine.
enum class Differentiation { by_hand, dual_numbers, differences };

}  // namespace binnacle
