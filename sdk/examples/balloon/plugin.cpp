// SPDX-License-Identifier: Apache-2.0
// The plugin balloon: a balloon in the wind, and bearings to landmarks.
#include "bearings.hpp"
#include "drift.hpp"

BINNACLE_PLUGIN("balloon", "1.0.0", registry) {
  registry.add<Drift>();
  registry.add<Bearings>();
}
