// SPDX-License-Identifier: Apache-2.0
// A plugin that lists its types, and notes that it was loaded.
#include <cstdlib>

#include "components.hpp"

namespace {
__attribute__((constructor)) void note() { setenv("BINNACLE_TEST_LISTED_LOADED", "1", 1); }
}  // namespace

BINNACLE_TYPES("still rest");
BINNACLE_PLUGIN("listed", "2.0.0", registry) {
  registry.add<loader_test::Still>();
  registry.add<loader_test::Rest>();
}
