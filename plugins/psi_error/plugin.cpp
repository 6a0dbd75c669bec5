// SPDX-License-Identifier: Apache-2.0
// What the plugin `psi_error` brings.
#include "binnacle/plugin.hpp"

#include "psi_error_process.hpp"

BINNACLE_TYPES("psi_error");

BINNACLE_PLUGIN("psi_error", "1.0.0", registry) { registry.add<binnacle::psi_error::PsiErrorProcess>(); }
