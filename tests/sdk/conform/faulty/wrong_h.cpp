// SPDX-License-Identifier: Apache-2.0
// H has the wrong sign in one column.
// fails: numbers.measurement.jacobian
#include "faulty.hpp"

namespace faulty::wrong_h {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (const auto H = out.H[p]) H(0, 1) = -H(0, 1);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_h")); }

}  // namespace faulty::wrong_h
