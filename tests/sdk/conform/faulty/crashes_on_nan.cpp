// SPDX-License-Identifier: Apache-2.0
// Looks a NaN up in a table.
// fails: robustness.nonfinite crash
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    static const double table[4] = {};
    const volatile auto index = static_cast<int>(sample.fields[0]);
    if (std::isnan(sample.fields[0])) out.residual[0] = *(static_cast<const volatile double*>(table) + index);
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("crashes_on_nan", "1.0.0", registry) { registry.add<Animal>(); }
