// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: its surroundings specify a sample of three rows, each beacon in its own place.
// fails: nothing
#include "ranges.hpp"

namespace faulty::rows_that_differ {

void add(Registry& registry) { registry.add<Ranges>(named<Ranges>("rows_that_differ")); }

}  // namespace faulty::rows_that_differ
