// SPDX-License-Identifier: Apache-2.0
// Its surroundings give a list for a field of which a sample has one: the example's fault, and said so.
// fails: metadata.example
#include "faulty.hpp"

namespace faulty::sample_of_wrong_shape {

class Subject final : public Measurement {
 public:
  static ComponentSpec spec() {
    auto spec = Measurement::spec();
    spec.surroundings = R"({"sample": {"range": [360, 361]}})";
    return spec;
  }
  using Measurement::Measurement;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("sample_of_wrong_shape")); }

}  // namespace faulty::sample_of_wrong_shape
