// SPDX-License-Identifier: Apache-2.0
// Normal deviates that keep nothing between draws.
#pragma once

#include <binnacle/random.hpp>

#include <cmath>
#include <numbers>

using Random = binnacle::random::Philox;

/// N(0, 1), by Box and Muller; the second one is not kept.
inline double normal(Random& random) {
  const double radius = std::sqrt(-2 * std::log1p(-binnacle::random::uniform(random)));
  return radius * std::cos(2 * std::numbers::pi * binnacle::random::uniform(random));
}
