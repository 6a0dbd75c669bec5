// SPDX-License-Identifier: Apache-2.0
// What the plugin `core` brings.
#include "binnacle/plugin.hpp"

#include "gauss_markov.hpp"
#include "integrated.hpp"
#include "linear.hpp"
#include "linear_measurement.hpp"
#include "pushed_source.hpp"
#include "random_constant.hpp"
#include "random_walk.hpp"
#include "vector_block.hpp"

BINNACLE_TYPES("vector gauss_markov integrated linear random_constant random_walk linear_measurement pushed");

BINNACLE_PLUGIN("core", "1.0.0", registry) {
  using namespace binnacle::core;
  registry.add<VectorBlock>();
  registry.add<RandomConstant>();
  registry.add<RandomWalk>();
  registry.add<PushedSource>();
  registry.add<GaussMarkov>();
  registry.add<Integrated>();
  registry.add<Linear>();
  registry.add<LinearMeasurement>();
}
