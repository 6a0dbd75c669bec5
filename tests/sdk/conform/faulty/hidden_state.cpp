// SPDX-License-Identifier: Apache-2.0
// Remembers in itself how often it was called.
// fails: life.repeatable
#include "faulty.hpp"

namespace faulty::hidden_state {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    out.x[p][0] += 1e-9 * calls_++;
    return result;
  }

 private:
  mutable int calls_ = 0;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("hidden_state")); }

}  // namespace faulty::hidden_state
