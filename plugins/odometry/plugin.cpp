// SPDX-License-Identifier: Apache-2.0
// What the plugin `odometry` brings.
#include "binnacle/plugin.hpp"

#include "heading_block.hpp"
#include "planar_odometry.hpp"

BINNACLE_TYPES("heading planar_odometry");

BINNACLE_PLUGIN("odometry", "1.0.0", registry) {
  using namespace binnacle::odometry;
  registry.add<HeadingBlock>();
  registry.add<PlanarOdometry>();
}
