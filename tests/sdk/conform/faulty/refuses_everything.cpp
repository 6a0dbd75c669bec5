// SPDX-License-Identifier: Apache-2.0
// Its H is wrong, and no sample that the suite can make up is taken: nothing of it is tried, so it does not conform.
// fails: verdict
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    if (!(in.sample[range] > 1e6)) return binnacle::Result::invalid("the beacon is beyond the mountains");
    const auto result = Measurement::linearize(in, out);
    if (const auto H = out.H[p]; result && H) H(0, 0) *= -7;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("refuses_everything", "1.0.0", registry) { registry.add<Subject>(); }
