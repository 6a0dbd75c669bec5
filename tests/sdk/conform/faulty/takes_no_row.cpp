// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: of a negative range it takes no row, which is not a refusal.
// fails: nothing
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result && !(in.sample[range] > 0)) out.rows = 0;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("takes_no_row", "1.0.0", registry) { registry.add<Subject>(); }
