// SPDX-License-Identifier: Apache-2.0
// The coarse_alignment plugin: its components.
#include "binnacle/plugin.hpp"

#include "coarse_alignment.hpp"

BINNACLE_TYPES("coarse_alignment");

BINNACLE_PLUGIN("coarse_alignment", "1.0.0", registry) { registry.add<binnacle::coarse_alignment::CoarseAlignment>(); }
