// SPDX-License-Identifier: Apache-2.0
// Reports more rows than it declared.
// fails: life.calls
#include "faulty.hpp"

namespace faulty::writes_too_many_rows {

class Subject final : public Measurement {
 public:
  using Measurement::Measurement;
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    out.rows = 2;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("writes_too_many_rows")); }

}  // namespace faulty::writes_too_many_rows
