// SPDX-License-Identifier: Apache-2.0
// What the plugin `ship_motion` brings.
#include "binnacle/plugin.hpp"

#include "gyro.hpp"
#include "motion.hpp"
#include "rate_integral.hpp"
#include "simulator.hpp"

BINNACLE_TYPES("motion rate_integral directional_gyro rate_gyro vertical_gyro simulator");

BINNACLE_PLUGIN("ship_motion", "1.0.0", registry) {
  using namespace binnacle::ship_motion;
  registry.add<Motion>();
  registry.add<RateIntegral>();
  registry.add<Simulator>();
  registry.add<VerticalGyro>();
  registry.add<DirectionalGyro>();
  registry.add<RateGyro>();
}
