// SPDX-License-Identifier: Apache-2.0
// What the plugin `phi_error` brings.
#include "binnacle/plugin.hpp"

#include "attitude_block.hpp"
#include "phi_error_process.hpp"
#include "position_block.hpp"
#include "velocity_block.hpp"

BINNACLE_PLUGIN("phi_error", "1.0.0", registry) {
  using namespace binnacle::phi_error;
  registry.add<PositionBlock>();
  registry.add<VelocityBlock>();
  registry.add<AttitudeBlock>();
  registry.add<PhiErrorProcess>();
}
