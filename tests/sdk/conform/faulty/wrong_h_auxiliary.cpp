// SPDX-License-Identifier: Apache-2.0
// H is −7 times what it should be, in a model whose beacon comes on an auxiliary channel.
// fails: numbers.measurement.jacobian
#include "beacon.hpp"

namespace faulty::wrong_h_auxiliary {

class Subject final : public Beacon {
 public:
  using Beacon::Beacon;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Beacon::linearize(in, out);
    if (const auto H = out.H[p]; result && H) H.as() *= -7;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_h_auxiliary")); }

}  // namespace faulty::wrong_h_auxiliary
