// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: its surroundings specify a sample of three rows, each beacon in its own place.
// fails: nothing
#include "ranges.hpp"

BINNACLE_PLUGIN("rows_that_differ", "1.0.0", registry) { registry.add<faulty::Ranges>(); }
