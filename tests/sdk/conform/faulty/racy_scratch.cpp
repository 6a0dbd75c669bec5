// SPDX-License-Identifier: Apache-2.0
// Uses one scratch array for all calls: two threads overwrite it for each other.
// fails: life.threads
#include "faulty.hpp"

#include <cmath>

namespace faulty::racy_scratch {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    scratch_[0] = in.x[p][0] + 300;
    scratch_[1] = in.x[p][1] + 200;
    for (int i = 0; i < 2000; ++i) scratch_[2 + i % 8] = std::hypot(scratch_[0], scratch_[1]);
    const double expected = scratch_[9];
    const auto result = Measurement::linearize(in, out);
    if (result) out.residual[0] = in.sample[range] - expected;
    return result;
  }

 private:
  mutable volatile double scratch_[10] = {};
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("racy_scratch")); }

}  // namespace faulty::racy_scratch
