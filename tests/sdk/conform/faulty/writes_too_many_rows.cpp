// SPDX-License-Identifier: Apache-2.0
// Reports more rows than it declared.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    out.rows = 2;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_too_many_rows", "1.0.0", registry) { registry.add<Subject>(); }
