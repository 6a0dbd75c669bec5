// SPDX-License-Identifier: Apache-2.0
// R of its two rows is not symmetric.
// fails: numbers.measurement.noise
#include "faulty.hpp"

namespace faulty::lopsided_r {

class Subject final : public Measurement {
 public:
  explicit Subject(const Binding& binding) : Measurement(binding) {
    declaration_.max_rows = 2;
    declaration_.groups[0].rows = 2;
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
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

void add(Registry& registry) { registry.add<Subject>(named<Subject>("lopsided_r")); }

}  // namespace faulty::lopsided_r
