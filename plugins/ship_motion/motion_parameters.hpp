// SPDX-License-Identifier: Apache-2.0
// The parameters of a motion: a shaping filter as it is, or what one is fitted to.
#pragma once

#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"
#include "shaping_filter.hpp"

namespace binnacle::ship_motion {

/// `omega`, `zeta`, `sigma`, or `fit`. `unit`: of the motion, as a parameter's unit.
std::vector<ParameterSpec> motion_parameters(const std::string& unit);

/// Reports the figures of a fit, and notes when it is poor. `si_unit`: of the motion.
ShapingFilter read_motion(const Binding& binding, const std::string& si_unit);

}  // namespace binnacle::ship_motion
