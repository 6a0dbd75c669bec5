// SPDX-License-Identifier: Apache-2.0
// Throws out of linearize().
// fails: life.calls
#include "faulty.hpp"

namespace faulty::throws_in_call {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result) throw std::runtime_error("no more");
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("throws_in_call")); }

}  // namespace faulty::throws_in_call
