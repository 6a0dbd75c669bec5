// SPDX-License-Identifier: Apache-2.0
// Wraps an angle by subtracting full turns: never over for a huge one.
// fails: robustness.finite timeout
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    volatile double angle = sample.fields[0];
    while (angle > 1e12 && std::isfinite(angle)) angle = angle - 6.28;
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("sleeps_on_huge", "1.0.0", registry) { registry.add<Animal>(); }
