// SPDX-License-Identifier: Apache-2.0
// Registers the same type twice.
// fails: load.register
#include "animal.hpp"

BINNACLE_PLUGIN("registers_twice", "1.0.0", registry) { registry.add<zoo::Process>(); registry.add<zoo::Process>(); }
