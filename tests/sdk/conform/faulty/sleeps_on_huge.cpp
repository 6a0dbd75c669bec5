// SPDX-License-Identifier: Apache-2.0
// Wraps an angle by subtracting full turns: never over for a huge one.
// fails: robustness.finite timeout
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    volatile double angle = in.sample[range];
    while (angle > 1e12 && std::isfinite(angle)) angle = angle - 6.28;
    const auto result = Measurement::linearize(in, out);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("sleeps_on_huge", "1.0.0", registry) { registry.add<Subject>(); }
