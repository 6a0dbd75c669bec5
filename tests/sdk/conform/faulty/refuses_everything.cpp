// SPDX-License-Identifier: Apache-2.0
// Its H is wrong, and no sample that the suite can make up is taken: nothing of it is tried, so it does not conform.
// fails: verdict
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Measurement {
 public:
  using Measurement::Measurement;
  binnacle::Result linearize(const binnacle::SampleView& sample, const binnacle::SampleView* auxiliary,
                             const double* const* x, const binnacle::legacy::Context& context, std::byte* memory,
                             binnacle::legacy::Linearization& out) const override {
    if (!(sample.fields[0] > 1e6)) return binnacle::Result::invalid("the beacon is beyond the mountains");
    const auto result = Measurement::linearize(sample, auxiliary, x, context, memory, out);
    if (result) out.H[0](0, 0) *= -7;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("refuses_everything", "1.0.0", registry) { registry.add<Subject>(); }
