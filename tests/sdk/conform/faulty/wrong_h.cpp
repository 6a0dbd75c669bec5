// SPDX-License-Identifier: Apache-2.0
// H has the wrong sign in one column.
// fails: numbers.measurement.jacobian
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (const auto H = out.H[p]) H(0, 1) = -H(0, 1);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_h", "1.0.0", registry) { registry.add<Subject>(); }
