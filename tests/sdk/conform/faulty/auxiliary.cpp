// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: its beacon comes on an auxiliary channel, given by the surroundings.
// fails: nothing
#include "beacon.hpp"

namespace faulty::auxiliary {

void add(Registry& registry) { registry.add<Beacon>(named<Beacon>("auxiliary")); }

}  // namespace faulty::auxiliary
