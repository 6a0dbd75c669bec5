// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: its beacon comes on an auxiliary channel, given by the surroundings.
// fails: nothing
#include "beacon.hpp"

BINNACLE_PLUGIN("auxiliary", "1.0.0", registry) { registry.add<faulty::Beacon>(); }
