// SPDX-License-Identifier: Apache-2.0
// The velocity falls with the position, and Phi does not say so.
// fails: numbers.process.jacobian
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (int i = 0; i < 2; ++i) out.x[v][i] -= 0.5 * in.step.dt * in.x[p][i];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("undeclared_coupling", "1.0.0", registry) { registry.add<Subject>(); }
