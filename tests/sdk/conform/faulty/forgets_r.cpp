// SPDX-License-Identifier: Apache-2.0
// It does not write the variance of its row.
// fails: numbers.measurement.noise
#include "faulty.hpp"

namespace faulty::forgets_r {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    out.R(0, 0) = 0;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("forgets_r")); }

}  // namespace faulty::forgets_r
