// SPDX-License-Identifier: Apache-2.0
// Its residual is twice what it should be when no H is wanted: at a residual of zero that does not show.
// fails: numbers.measurement.value
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && !out.H) out.residual[0] *= 2;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("doubled_residual", "1.0.0", registry) { registry.add<Subject>(); }
