// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: the control.
// fails: nothing
#include "faulty.hpp"

BINNACLE_PLUGIN("healthy", "1.0.0", registry) { faulty::register_all(registry); }
