// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: of a negative range it takes no row, which is not a refusal.
// fails: nothing
#include "faulty.hpp"

namespace faulty::takes_no_row {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && !(in.sample[range] > 0)) out.rows = 0;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("takes_no_row")); }

}  // namespace faulty::takes_no_row
