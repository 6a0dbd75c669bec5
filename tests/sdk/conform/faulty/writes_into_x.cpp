// SPDX-License-Identifier: Apache-2.0
// Writes into the state that it is to read.
// fails: life.calls
#include "faulty.hpp"

namespace faulty::writes_into_x {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    const_cast<double*>(in.x[p].data())[1] += 1;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("writes_into_x")); }

}  // namespace faulty::writes_into_x
