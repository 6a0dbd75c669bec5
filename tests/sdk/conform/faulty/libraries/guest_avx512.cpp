// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx512f -mfma: accepted where the processor has them, refused where not.
// fails: load.guard warn/fail
#include "../faulty.hpp"

BINNACLE_PLUGIN("guest_avx512", "1.0.0", registry) { faulty::register_all(registry); }
