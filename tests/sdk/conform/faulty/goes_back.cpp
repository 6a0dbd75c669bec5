// SPDX-License-Identifier: Apache-2.0
// Every tenth sample is a second late.
// fails: numbers.source.order
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  binnacle::SourceStatus next(std::byte* memory, binnacle::SampleSlot* slots, int& channel) const override {
    State state;
    std::memcpy(&state, memory, sizeof state);
    const auto status = Source::next(memory, slots, channel);
    if (status == binnacle::SourceStatus::sample && state.count % 10 == 9) slots[0].t -= 1'000'000'000;
    return status;
  }
};

}  // namespace

BINNACLE_PLUGIN("goes_back", "1.0.0", registry) { registry.add<Subject>(); }
