// SPDX-License-Identifier: Apache-2.0
// Leaves a symbol of its own visible to other libraries.
// fails: load.symbols
#include "../faulty.hpp"

extern "C" __attribute__((visibility("default"), used)) int helper_of_mine() { return 1; }
BINNACLE_PLUGIN("exports_more", "1.0.0", registry) { registry.add<faulty::Process>(); }
