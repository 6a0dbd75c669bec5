// SPDX-License-Identifier: Apache-2.0
// Compiled by clang: accepted, with or without a warning of the guard.
// fails: load.guard pass/warn
#include "../faulty.hpp"

BINNACLE_PLUGIN("guest_clang", "1.0.0", registry) { faulty::register_all(registry); }
