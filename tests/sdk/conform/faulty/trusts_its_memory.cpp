// SPDX-License-Identifier: Apache-2.0
// Uses a number in its memory as an index without looking.
// fails: robustness.memory crash
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Source {
 public:
  using Source::Source;
  binnacle::SourceStatus next(const binnacle::MemoryView& memory, binnacle::SourceOutput& out) const override {
    const State state = memory[place];
    static const double table[256] = {};
    if (state.count >= samples && state.count < 256) return binnacle::SourceStatus::end;
    const volatile double* at = table + state.count;
    if (*at > 0) return binnacle::SourceStatus::end;
    return Source::next(memory, out);
  }
};

}  // namespace

BINNACLE_PLUGIN("trusts_its_memory", "1.0.0", registry) { registry.add<Subject>(); }
