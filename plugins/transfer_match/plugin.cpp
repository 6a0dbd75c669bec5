// SPDX-License-Identifier: Apache-2.0
// What the plugin `transfer_match` brings.
#include "binnacle/plugin.hpp"

#include "dcm_match.hpp"
#include "mounting_block.hpp"
#include "velocity_match.hpp"

BINNACLE_TYPES("mounting dcm_match velocity_match");

BINNACLE_PLUGIN("transfer_match", "1.0.0", registry) {
  using namespace binnacle::transfer_match;
  registry.add<MountingBlock>();
  registry.add<VelocityMatch>();
  registry.add<DcmMatch>();
}
