// SPDX-License-Identifier: Apache-2.0
// What the plugin `phi_error` brings.
#include "binnacle/plugin.hpp"

#include "phi_error_process.hpp"

BINNACLE_TYPES("phi_error");

BINNACLE_PLUGIN("phi_error", "1.0.0", registry) { registry.add<binnacle::phi_error::PhiErrorProcess>(); }
