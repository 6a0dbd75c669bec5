// SPDX-License-Identifier: Apache-2.0
// The plugin robust.
#include "binnacle/plugin.hpp"
#include "robust_noise.hpp"

BINNACLE_TYPES("cauchy dcs huber student_t");

BINNACLE_PLUGIN("robust", "1.0.0", registry) {
  registry.add<binnacle::robust::Huber>();
  registry.add<binnacle::robust::Cauchy>();
  registry.add<binnacle::robust::StudentT>();
  registry.add<binnacle::robust::DynamicCovarianceScaling>();
}
