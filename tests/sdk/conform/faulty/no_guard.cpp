// SPDX-License-Identifier: Apache-2.0
// Exports no guard.
// fails: load.guard
#include "faulty.hpp"

extern "C" __attribute__((visibility("default"), used)) void binnacle_register_v1(binnacle::Registry& registry) {
  registry.add<faulty::Process>();
}
