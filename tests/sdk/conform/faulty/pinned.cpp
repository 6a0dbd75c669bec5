// SPDX-License-Identifier: Apache-2.0
// Stays in memory for ever: linked with -z nodelete.
// fails: load.cycle
#include "faulty.hpp"

BINNACLE_PLUGIN("pinned", "1.0.0", registry) { registry.add<faulty::Process>(); }
