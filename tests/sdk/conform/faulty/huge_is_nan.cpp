// SPDX-License-Identifier: Apache-2.0
// Overflows to a number that is none, and does not say so.
// fails: robustness.finite
#include "faulty.hpp"

namespace faulty::huge_is_nan {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result)
      out.residual[0] = in.sample[range] * in.sample[range] / in.sample[range] - (in.sample[range] - out.residual[0]);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("huge_is_nan")); }

}  // namespace faulty::huge_is_nan
