// SPDX-License-Identifier: Apache-2.0
// Looks a NaN up in a table.
// fails: robustness.nonfinite crash
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    static const double table[4] = {};
    const volatile auto index = static_cast<int>(in.sample[range]);
    if (std::isnan(in.sample[range])) out.residual[0] = *(static_cast<const volatile double*>(table) + index);
    const auto result = Measurement::linearize(in, out);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("crashes_on_nan", "1.0.0", registry) { registry.add<Subject>(); }
