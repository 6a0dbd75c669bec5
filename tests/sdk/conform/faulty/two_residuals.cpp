// SPDX-License-Identifier: Apache-2.0
// Its residual is another one, by a nanometre, when no H is wanted.
// fails: numbers.measurement.value
#include "faulty.hpp"

namespace faulty::two_residuals {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && !out.H) out.residual[0] += 1e-9;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("two_residuals")); }

}  // namespace faulty::two_residuals
