// SPDX-License-Identifier: Apache-2.0
// Stays in memory for ever: linked with -z nodelete.
// fails: load.cycle
#include "animal.hpp"

BINNACLE_PLUGIN("pinned", "1.0.0", registry) { registry.add<zoo::Process>(); }
