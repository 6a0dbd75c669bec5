// SPDX-License-Identifier: Apache-2.0
// Looks a NaN up in a table.
// fails: robustness.nonfinite crash
#include "faulty.hpp"

#include <cmath>

namespace faulty::crashes_on_nan {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    static const double table[4] = {};
    const volatile auto index = static_cast<int>(in.sample[range]);
    if (std::isnan(in.sample[range])) out.residual[0] = *(static_cast<const volatile double*>(table) + index);
    const auto result = Measurement::linearize(in, out);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("crashes_on_nan")); }

}  // namespace faulty::crashes_on_nan
