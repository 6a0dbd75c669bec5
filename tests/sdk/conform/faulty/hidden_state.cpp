// SPDX-License-Identifier: Apache-2.0
// Remembers in itself how often it was called.
// fails: life.repeatable
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    out.x_plus[0][0] += 1e-9 * calls_++;
    return result;
  }

 private:
  mutable int calls_ = 0;
};

}  // namespace

BINNACLE_PLUGIN("hidden_state", "1.0.0", registry) { registry.add<Animal>(); }
