// SPDX-License-Identifier: Apache-2.0
// Its surroundings give a list for a field of which a sample has one: the example's fault, and said so.
// fails: metadata.example
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  static binnacle::ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.surroundings = R"({"sample": {"range": [360, 361]}})";
    return spec;
  }
  using Measurement::Measurement;
};

}  // namespace

BINNACLE_PLUGIN("sample_of_wrong_shape", "1.0.0", registry) { registry.add<Subject>(); }
