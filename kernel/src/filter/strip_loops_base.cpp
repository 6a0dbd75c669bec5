// SPDX-License-Identifier: Apache-2.0
// StripLoops for what every processor has: two doubles to a register.
namespace binnacle::filter {
namespace {
constexpr int lanes = 2;
}
}  // namespace binnacle::filter

#include "filter/strip_loops_body.hpp"

const binnacle::filter::StripLoops binnacle::filter::base_strip_loops = {combine, combine_neighbours, transpose,
                                                                         mirror,  gain_columns,       correct_lower};
