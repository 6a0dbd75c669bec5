// SPDX-License-Identifier: Apache-2.0
// Every tenth sample is a second late.
// fails: numbers.source.order
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  binnacle::SourceStatus next(const binnacle::MemoryView& memory, binnacle::SourceOutput& out) const override {
    const std::int64_t count = memory[place].count;
    const auto status = Source::next(memory, out);
    if (status == binnacle::SourceStatus::sample && count % 10 == 9) out.on(channel).t -= 1'000'000'000;
    return status;
  }
};

}  // namespace

BINNACLE_PLUGIN("goes_back", "1.0.0", registry) { registry.add<Subject>(); }
