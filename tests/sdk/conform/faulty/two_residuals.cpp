// SPDX-License-Identifier: Apache-2.0
// Its residual is another one, by a nanometre, when no H is wanted.
// fails: numbers.measurement.value
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && !out.H) out.residual[0] += 1e-9;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("two_residuals", "1.0.0", registry) { registry.add<Subject>(); }
