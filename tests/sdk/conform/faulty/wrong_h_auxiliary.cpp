// SPDX-License-Identifier: Apache-2.0
// H is −7 times what it should be, in a model whose beacon comes on an auxiliary channel.
// fails: numbers.measurement.jacobian
#include "beacon.hpp"

namespace {

class Subject final : public faulty::Beacon {
 public:
  using Beacon::Beacon;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Beacon::linearize(in, out);
    if (const auto H = out.H[p]; result && H) H.as() *= -7;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_h_auxiliary", "1.0.0", registry) { registry.add<Subject>(); }
