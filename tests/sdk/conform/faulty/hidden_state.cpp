// SPDX-License-Identifier: Apache-2.0
// Remembers in itself how often it was called.
// fails: life.repeatable
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    out.x[p][0] += 1e-9 * calls_++;
    return result;
  }

 private:
  mutable int calls_ = 0;
};

}  // namespace

BINNACLE_PLUGIN("hidden_state", "1.0.0", registry) { registry.add<Subject>(); }
