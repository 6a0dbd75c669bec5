// SPDX-License-Identifier: Apache-2.0
// What the plugin `gnss_fix` brings.
#include "binnacle/plugin.hpp"

#include "position_fix.hpp"
#include "pv_fix.hpp"
#include "velocity_fix.hpp"

BINNACLE_TYPES("position_fix pv_fix velocity_fix");

BINNACLE_PLUGIN("gnss_fix", "1.0.0", registry) {
  using namespace binnacle::gnss_fix;
  registry.add<PositionFix>();
  registry.add<VelocityFix>();
  registry.add<PvFix>();
}
