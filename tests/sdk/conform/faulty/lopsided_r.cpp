// SPDX-License-Identifier: Apache-2.0
// R of its two rows is not symmetric.
// fails: numbers.measurement.noise
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  explicit Subject(const binnacle::Binding& binding) : Measurement(binding) {
    declaration_.max_rows = 2;
    declaration_.groups[0].rows = 2;
  }
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    out.rows = 2;
    out.residual[1] = out.residual[0];
    if (const auto H = out.H[p])
      for (int i = 0; i < 2; ++i) H(1, i) = H(0, i);
    out.R(1, 1) = out.R(0, 0);
    out.R(0, 1) = 0.1 * out.R(0, 0);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("lopsided_r", "1.0.0", registry) { registry.add<Subject>(); }
