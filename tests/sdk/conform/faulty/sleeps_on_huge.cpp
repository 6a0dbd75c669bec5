// SPDX-License-Identifier: Apache-2.0
// Wraps an angle by subtracting full turns: never over for a huge one.
// fails: robustness.finite timeout
#include <cmath>

#include <unistd.h>

#include "faulty.hpp"

namespace faulty::sleeps_on_huge {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    volatile double angle = in.sample[range];
    while (angle > 1e12 && std::isfinite(angle)) {
      angle = angle - 6.28;
      ::usleep(1000);  // costs no processor time
    }
    const auto result = Measurement::linearize(in, out);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("sleeps_on_huge")); }

}  // namespace faulty::sleeps_on_huge
