// SPDX-License-Identifier: Apache-2.0
// Compiled with -march=native: accepted, and told where Eigen aligns otherwise.
// fails: load.guard warn
#include "animal.hpp"

BINNACLE_PLUGIN("guest_native", "1.0.0", registry) { zoo::register_all(registry); }
