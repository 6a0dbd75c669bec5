// SPDX-License-Identifier: Apache-2.0
// Has a ceiling for R and does not look at it.
// fails: numbers.noise.bounds
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  using Noise::Noise;
  static binnacle::ComponentSpec spec() {
    auto spec = Noise::spec();
    spec.parameters.push_back(
        binnacle::parameter::number("ceiling", "1").above(0).about("factor on the nominal 1-sigma"));
    return spec;
  }
};

}  // namespace

BINNACLE_PLUGIN("ignores_ceiling", "1.0.0", registry) { registry.add<Subject>(); }
