// SPDX-License-Identifier: Apache-2.0
// Makes noise in no time.
// fails: numbers.process.rest
#include "faulty.hpp"

namespace faulty::moves_at_rest {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (in.step.dt == 0) set(out.Qd, q_vv, 0, 1e-9);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("moves_at_rest")); }

}  // namespace faulty::moves_at_rest
