// SPDX-License-Identifier: Apache-2.0
// Another plugin with a component of the same name.
#include "components.hpp"

BINNACLE_PLUGIN("second", "0.1", registry) { registry.add<loader_test::Still>(); }
