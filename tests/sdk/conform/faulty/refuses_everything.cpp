// SPDX-License-Identifier: Apache-2.0
// Its H is wrong, and no sample that the suite can make up is taken: nothing of it is tried, so it does not conform.
// fails: verdict
#include "faulty.hpp"

namespace faulty::refuses_everything {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    if (!(in.sample[range] > 1e6)) return Result::invalid("the beacon is beyond the mountains");
    const auto result = Measurement::linearize(in, out);
    if (const auto H = out.H[p]; result && H) H(0, 0) *= -7;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("refuses_everything")); }

}  // namespace faulty::refuses_everything
