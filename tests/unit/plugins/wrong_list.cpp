// SPDX-License-Identifier: Apache-2.0
// A plugin that lists one type of its two, and one that it has not.
#include "components.hpp"

BINNACLE_TYPES("still restless");
BINNACLE_PLUGIN("wrong_list", "1", registry) {
  registry.add<loader_test::Still>();
  registry.add<loader_test::Rest>();
}
