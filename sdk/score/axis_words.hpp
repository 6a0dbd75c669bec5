// SPDX-License-Identifier: Apache-2.0
// What is wrong with axes, signs and scales of an inertial input, in words.
#pragma once

#include <string>
#include <vector>

#include "input_fit.hpp"
#include "motion_fields.hpp"

namespace binnacle::score {

/// Empty where nothing is, or too little motion says anything. `velocity_is_right`: the position of the fix says so.
std::vector<std::string> axis_words(const InputFit::Axes& axes, const InertialFields& input, const FixFields& fix,
                                    bool velocity_is_right);

}  // namespace binnacle::score
