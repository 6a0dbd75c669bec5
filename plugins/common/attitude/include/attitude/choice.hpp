// SPDX-License-Identifier: Apache-2.0
// Which attitude algorithm a config chose.
#pragma once

#include "attitude/algorithm.hpp"
#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::attitude {

/// The parameter "attitude" of a component that updates an attitude from gyro increments.
ParameterSpec choice_parameter();

/// Throws ComponentError where its samples are not those of a step.
Algorithm read_choice(const Binding& binding);

}  // namespace binnacle::attitude
