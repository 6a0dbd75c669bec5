// SPDX-License-Identifier: Apache-2.0
// Every tenth sample is a second late.
// fails: numbers.source.order
#include "faulty.hpp"

namespace faulty::goes_back {

class Subject final : public Source {
 public:
  using Source::Source;
  SourceStatus next(const MemoryView& memory, SourceOutput& out) const override {
    const std::int64_t count = memory[place].count;
    const auto status = Source::next(memory, out);
    if (status == SourceStatus::sample && count % 10 == 9) out.on(channel).t -= 1'000'000'000;
    return status;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("goes_back")); }

}  // namespace faulty::goes_back
