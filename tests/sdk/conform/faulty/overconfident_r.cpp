// SPDX-License-Identifier: Apache-2.0
// R is a ninth of what it should be wherever there is noise to see: wrong however small the errors are.
// fails: numbers.measurement.consistency
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && std::abs(out.residual[0]) > 1e-3 * sigma) out.R(0, 0) /= 9;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("overconfident_r", "1.0.0", registry) { registry.add<Subject>(); }
