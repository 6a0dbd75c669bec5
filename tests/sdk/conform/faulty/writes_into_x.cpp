// SPDX-License-Identifier: Apache-2.0
// Writes into the state that it is to read.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    const_cast<double*>(in.x[p].data())[1] += 1;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_into_x", "1.0.0", registry) { registry.add<Subject>(); }
