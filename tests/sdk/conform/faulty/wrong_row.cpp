// SPDX-License-Identifier: Apache-2.0
// H is wrong in the third row of a sample whose rows differ.
// fails: numbers.measurement.jacobian
#include "ranges.hpp"

namespace {

class Subject final : public faulty::Ranges {
 public:
  using Ranges::Ranges;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    const auto result = Ranges::linearize(sample, auxiliary, x, context, memory, out);
    if (out.rows > 2) out.H[0](2, 1) = -out.H[0](2, 1);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_row", "1.0.0", registry) { registry.add<Subject>(); }
