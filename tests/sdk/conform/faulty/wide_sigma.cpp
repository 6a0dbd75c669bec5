// SPDX-License-Identifier: Apache-2.0
// The model is right; its example starts a filter so far from the truth that the range's second order exceeds R.
// fails: numbers.measurement.consistency warn
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.surroundings = R"({"blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "sigma": 40}}})";
    return spec;
  }
  using Measurement::Measurement;
};

}  // namespace

BINNACLE_PLUGIN("wide_sigma", "1.0.0", registry) { registry.add<Subject>(); }
