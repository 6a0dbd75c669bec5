// SPDX-License-Identifier: Apache-2.0
// H has the wrong sign in one column.
// fails: numbers.measurement.jacobian
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    out.H[0](0, 1) = -out.H[0](0, 1);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_h", "1.0.0", registry) { registry.add<Animal>(); }
