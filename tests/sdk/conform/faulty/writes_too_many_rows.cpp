// SPDX-License-Identifier: Apache-2.0
// Tells more rows than it declared.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    out.rows = 2;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_too_many_rows", "1.0.0", registry) { registry.add<Animal>(); }
