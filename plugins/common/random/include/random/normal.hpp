// SPDX-License-Identifier: Apache-2.0
// Normal deviates that keep nothing between draws.
#pragma once

#include <boost/random/normal_distribution.hpp>

#include "random/philox.hpp"

namespace binnacle::random {

/// A deviate of N(0, 1). Boost.Random's ziggurat (since 1.56) has no cached second value, so the engine is
/// all the state there is. It takes one draw in most cases and more in some: the number of draws is not
/// fixed.
inline double normal(Philox& engine) { return boost::random::normal_distribution<double>()(engine); }

/// Three independent ones.
inline std::array<double, 3> normal3(Philox& engine) {
  const double x = normal(engine);
  const double y = normal(engine);
  const double z = normal(engine);
  return {x, y, z};
}

}  // namespace binnacle::random
