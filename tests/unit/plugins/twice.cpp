// SPDX-License-Identifier: Apache-2.0
// A plugin that registers one type twice.
#include "components.hpp"

BINNACLE_PLUGIN("twice", "1", registry) {
  registry.add<loader_test::Still>();
  registry.add<loader_test::Still>();
}
