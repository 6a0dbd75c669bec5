// SPDX-License-Identifier: Apache-2.0
// Compiled with -march=native: accepted, and told where Eigen aligns otherwise.
// fails: load.guard warn
#include "animal.hpp"

BINNACLE_PLUGIN("guest_native", "1.0.0", registry) {
  registry.add<zoo::Process>();
  registry.add<zoo::Measurement>();
  registry.add<zoo::Derived>();
  registry.add<zoo::Block>();
  registry.add<zoo::Noise>();
  registry.add<zoo::Source>();
  registry.add<zoo::Transform>();
}
