// SPDX-License-Identifier: Apache-2.0
// Overflows to a number that is none, and does not say so.
// fails: robustness.finite
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result)
      out.residual[0] = in.sample[range] * in.sample[range] / in.sample[range] - (in.sample[range] - out.residual[0]);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("huge_is_nan", "1.0.0", registry) { registry.add<Subject>(); }
