// SPDX-License-Identifier: Apache-2.0
// The plugin adaptive_noise.
#include "binnacle/plugin.hpp"
#include "beta_adapter.hpp"
#include "innovation_window.hpp"
#include "sage_husa.hpp"

BINNACLE_TYPES("beta_adapter innovation_window sage_husa");

BINNACLE_PLUGIN("adaptive_noise", "1.0.0", registry) {
  registry.add<binnacle::adaptive_noise::BetaAdapter>();
  registry.add<binnacle::adaptive_noise::SageHusa>();
  registry.add<binnacle::adaptive_noise::InnovationWindow>();
}
