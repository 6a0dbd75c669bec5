// SPDX-License-Identifier: Apache-2.0
// How far from zero times may be.
#pragma once

#include "binnacle/time.hpp"

namespace binnacle::internal::base {

/// Instants and durations beyond are refused where they come in: then every sum and difference of two is a number.
constexpr Time farthest_time = (Time{1} << 62) - 1;
constexpr const char* farthest_text = "146 years";

constexpr bool is_near(Time t) { return t >= -farthest_time && t <= farthest_time; }

}  // namespace binnacle::internal::base
