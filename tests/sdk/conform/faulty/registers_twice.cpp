// SPDX-License-Identifier: Apache-2.0
// Registers the same type twice.
// fails: load.register
#include "faulty.hpp"

BINNACLE_PLUGIN("registers_twice", "1.0.0", registry) {
  registry.add<faulty::Process>();
  registry.add<faulty::Process>();
}
