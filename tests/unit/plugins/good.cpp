// SPDX-License-Identifier: Apache-2.0
// A plugin as it should be.
#include "components.hpp"

BINNACLE_PLUGIN("good", "1.2.3", registry) {
  registry.add<loader_test::Still>();
  registry.add<loader_test::Thrower>();
  registry.add<loader_test::Rest>();
}
