// SPDX-License-Identifier: Apache-2.0
// H is wrong in the third row of a sample whose rows differ.
// fails: numbers.measurement.jacobian
#include "ranges.hpp"

namespace faulty::wrong_row {

class Subject final : public Ranges {
 public:
  using Ranges::Ranges;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Ranges::linearize(in, out);
    if (const auto H = out.H[p]; out.rows > 2 && H) H(2, 1) = -H(2, 1);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_row")); }

}  // namespace faulty::wrong_row
