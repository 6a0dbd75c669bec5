// SPDX-License-Identifier: Apache-2.0
// What the plugin `aiding` brings.
#include "binnacle/plugin.hpp"
#include "bearing.hpp"
#include "range.hpp"
#include "range_difference.hpp"

BINNACLE_PLUGIN("aiding", "1.0.0", registry) {
  registry.add<binnacle::aiding::Bearing>();
  registry.add<binnacle::aiding::Range>();
  registry.add<binnacle::aiding::RangeDifference>();
}
