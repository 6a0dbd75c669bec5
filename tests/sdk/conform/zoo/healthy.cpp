// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: the control.
// fails: nothing
#include "animal.hpp"

BINNACLE_PLUGIN("healthy", "1.0.0", registry) {
  registry.add<zoo::Process>();
  registry.add<zoo::Measurement>();
  registry.add<zoo::Derived>();
  registry.add<zoo::Block>();
  registry.add<zoo::Noise>();
  registry.add<zoo::Source>();
  registry.add<zoo::Transform>();
}
