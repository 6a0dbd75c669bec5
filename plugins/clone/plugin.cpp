// SPDX-License-Identifier: Apache-2.0
// What the plugin `clone` brings.
#include "binnacle/plugin.hpp"

#include "clone.hpp"
#include "displacement.hpp"
#include "relative_position.hpp"

BINNACLE_TYPES("clone relative_position displacement");

BINNACLE_PLUGIN("clone", "1.0.0", registry) {
  using namespace binnacle::clone;
  registry.add<Clone>();
  registry.add<RelativePosition>();
  registry.add<Displacement>();
}
