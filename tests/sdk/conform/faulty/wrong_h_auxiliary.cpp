// SPDX-License-Identifier: Apache-2.0
// H is −7 times what it should be, in a model whose beacon comes on an auxiliary channel.
// fails: numbers.measurement.jacobian
#include "beacon.hpp"

namespace {

class Subject final : public faulty::Beacon {
 public:
  using Beacon::Beacon;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    const auto result = Beacon::linearize(sample, auxiliary, x, context, memory, out);
    if (result) out.H[0](0, 0) *= -7, out.H[0](0, 1) *= -7;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_h_auxiliary", "1.0.0", registry) { registry.add<Subject>(); }
