// SPDX-License-Identifier: Apache-2.0
// R of its two rows is not symmetric.
// fails: numbers.measurement.noise
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Measurement {
 public:
  explicit Animal(const binnacle::Binding& binding) : Measurement(binding) {
    declared.max_rows = 2;
    declared.groups[0].rows = 2;
  }
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    out.rows = 2;
    out.residual[1] = out.residual[0];
    for (int i = 0; i < 2; ++i) out.H[0](1, i) = out.H[0](0, i);
    out.R(1, 1) = out.R(0, 0);
    out.R(0, 1) = 0.1 * out.R(0, 0);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("lopsided_r", "1.0.0", registry) { registry.add<Animal>(); }
