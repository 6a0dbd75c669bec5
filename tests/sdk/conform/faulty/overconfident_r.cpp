// SPDX-License-Identifier: Apache-2.0
// R is a ninth of what it should be wherever there is noise to see: wrong however small the errors are.
// fails: numbers.measurement.consistency
#include "faulty.hpp"

#include <cmath>

namespace faulty::overconfident_r {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && std::abs(out.residual[0]) > 1e-3 * sigma) out.R(0, 0) /= 9;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("overconfident_r")); }

}  // namespace faulty::overconfident_r
