// SPDX-License-Identifier: Apache-2.0
// The parameters of ride and body.
#pragma once

#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "body.hpp"

namespace binnacle::vehicle_simulator {

/// ride, boarding, shaking, lever_arm, mounting: all off unless given.
std::vector<ParameterSpec> body_parameters();
/// Throws ComponentError at what contradicts itself.
BodyModel read_body(const Parameters& parameters);

}  // namespace binnacle::vehicle_simulator
