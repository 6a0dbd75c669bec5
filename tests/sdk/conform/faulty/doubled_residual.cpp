// SPDX-License-Identifier: Apache-2.0
// Its residual is twice what it should be when no H is wanted: at a residual of zero that does not show.
// fails: numbers.measurement.value
#include "faulty.hpp"

namespace faulty::doubled_residual {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && !out.H) out.residual[0] *= 2;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("doubled_residual")); }

}  // namespace faulty::doubled_residual
