// SPDX-License-Identifier: Apache-2.0
// A plugin with a library of its own beside it.
#include "components.hpp"

extern "C" int binnacle_test_beside();

BINNACLE_PLUGIN("looks_beside", "1", registry) {
  if (binnacle_test_beside() == 7) registry.add<loader_test::Still>();
}
