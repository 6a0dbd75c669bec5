// SPDX-License-Identifier: Apache-2.0
// A plugin that needs a function nobody has; linked without --no-undefined.
#include "components.hpp"

extern "C" void binnacle_test_nobody_has_this();

BINNACLE_PLUGIN("unresolved", "1", registry) {
  registry.add<loader_test::Still>();
  binnacle_test_nobody_has_this();
}
