// SPDX-License-Identifier: Apache-2.0
// Throws where it should register.
// fails: load.register
#include "faulty.hpp"

BINNACLE_PLUGIN("throws_at_registration", "1.0.0", registry) {
  registry.add<faulty::Process>();
  throw 7;
}
