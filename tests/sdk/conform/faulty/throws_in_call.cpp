// SPDX-License-Identifier: Apache-2.0
// Throws out of linearize().
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const auto result = Measurement::linearize(in, out);
    if (result) throw std::runtime_error("no more");
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("throws_in_call", "1.0.0", registry) { registry.add<Subject>(); }
