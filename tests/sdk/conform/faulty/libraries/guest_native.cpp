// SPDX-License-Identifier: Apache-2.0
// Compiled with -march=native: accepted, with a warning where Eigen aligns otherwise.
// fails: load.guard warn
#include "../faulty.hpp"

BINNACLE_PLUGIN("guest_native", "1.0.0", registry) { faulty::register_all(registry); }
