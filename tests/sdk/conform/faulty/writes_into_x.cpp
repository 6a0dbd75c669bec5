// SPDX-License-Identifier: Apache-2.0
// Writes into the state that it is to read.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    const_cast<double*>(x[0])[1] += 1;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_into_x", "1.0.0", registry) { registry.add<Subject>(); }
