// SPDX-License-Identifier: Apache-2.0
// StripLoops for what every processor has: two doubles to a register.
namespace binnacle {
namespace {
constexpr int lanes = 2;
}
}  // namespace binnacle

#include "filter/strip_loops_body.hpp"

const binnacle::StripLoops binnacle::base_strip_loops = {combine, correct_lower};
