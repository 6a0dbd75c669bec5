// SPDX-License-Identifier: Apache-2.0
// What the plugin `land` brings.
#include "binnacle/plugin.hpp"

#include "level.hpp"
#include "nhc.hpp"
#include "odometer.hpp"
#include "zero_rate.hpp"
#include "zupt.hpp"

BINNACLE_TYPES("level nhc odometer zero_rate zupt");

BINNACLE_PLUGIN("land", "1.0.0", registry) {
  using namespace binnacle::land;
  registry.add<Level>();
  registry.add<Nhc>();
  registry.add<Odometer>();
  registry.add<ZeroRate>();
  registry.add<Zupt>();
}
