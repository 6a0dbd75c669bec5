// SPDX-License-Identifier: Apache-2.0
// The velocity falls with the position, and Phi does not say so.
// fails: numbers.process.jacobian
#include "faulty.hpp"

namespace faulty::undeclared_coupling {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (int i = 0; i < 2; ++i) out.x[v][i] -= 0.5 * in.step.dt * in.x[p][i];
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("undeclared_coupling")); }

}  // namespace faulty::undeclared_coupling
