// SPDX-License-Identifier: Apache-2.0
// H is wrong in the third row of a sample whose rows differ.
// fails: numbers.measurement.jacobian
#include "ranges.hpp"

namespace {

class Subject final : public faulty::Ranges {
 public:
  using Ranges::Ranges;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Ranges::linearize(in, out);
    if (const auto H = out.H[p]; out.rows > 2 && H) H(2, 1) = -H(2, 1);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_row", "1.0.0", registry) { registry.add<Subject>(); }
