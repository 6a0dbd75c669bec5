// SPDX-License-Identifier: Apache-2.0
// Uses a number in its memory as an index without looking.
// fails: robustness.memory crash
#include "faulty.hpp"

namespace faulty::trusts_its_memory {

class Subject final : public Source {
 public:
  using Source::Source;
  SourceStatus next(const MemoryView& memory, SourceOutput& out) const override {
    const State state = memory[place];
    static const double table[256] = {};
    if (state.count >= samples && state.count < 256) return SourceStatus::end;
    const volatile double* at = table + state.count;
    if (*at > 0) return SourceStatus::end;
    return Source::next(memory, out);
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("trusts_its_memory")); }

}  // namespace faulty::trusts_its_memory
