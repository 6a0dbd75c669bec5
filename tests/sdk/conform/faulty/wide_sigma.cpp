// SPDX-License-Identifier: Apache-2.0
// The model is right; its example starts a filter so far from the truth that the range's second order exceeds R.
// fails: numbers.measurement.consistency warn
#include "faulty.hpp"

namespace faulty::wide_sigma {

class Subject final : public Measurement {
 public:
  static ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.surroundings = R"({"blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "sigma": 40}}})";
    return spec;
  }
  using Measurement::Measurement;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wide_sigma")); }

}  // namespace faulty::wide_sigma
