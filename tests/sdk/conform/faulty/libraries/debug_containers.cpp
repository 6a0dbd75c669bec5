// SPDX-License-Identifier: Apache-2.0
// Compiled with _GLIBCXX_DEBUG: the standard containers have another layout.
// fails: load.guard
#include "../faulty.hpp"

BINNACLE_PLUGIN("debug_containers", "1.0.0", registry) { registry.add<faulty::Process>(); }
