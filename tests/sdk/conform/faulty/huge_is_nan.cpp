// SPDX-License-Identifier: Apache-2.0
// Overflows to a number that is none, and does not say so.
// fails: robustness.finite
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    if (result)
      out.residual[0] = sample.fields[0] * sample.fields[0] / sample.fields[0] - (sample.fields[0] - out.residual[0]);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("huge_is_nan", "1.0.0", registry) { registry.add<Animal>(); }
