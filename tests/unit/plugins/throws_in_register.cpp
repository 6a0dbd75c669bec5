// SPDX-License-Identifier: Apache-2.0
// A plugin whose registration fails half way.
#include "components.hpp"

BINNACLE_PLUGIN("throws_in_register", "1", registry) {
  registry.add<loader_test::Still>();
  throw loader_test::OwnError("out of ideas");
}
