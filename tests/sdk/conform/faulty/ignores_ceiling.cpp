// SPDX-License-Identifier: Apache-2.0
// Has a ceiling for R and does not look at it.
// fails: numbers.noise.bounds
#include "faulty.hpp"

namespace faulty::ignores_ceiling {

class Subject final : public Noise {
 public:
  using Noise::Noise;
  static ComponentSpec spec() {
    auto spec = Noise::spec();
    spec.parameters.push_back(parameter::number("ceiling", "1").above(0).about("factor on the nominal 1-sigma"));
    return spec;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("ignores_ceiling")); }

}  // namespace faulty::ignores_ceiling
