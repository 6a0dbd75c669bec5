// SPDX-License-Identifier: Apache-2.0
// The velocity falls with the position, and Phi does not say so.
// fails: numbers.process.jacobian
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    for (int i = 0; i < 2; ++i) out.x_plus[1][i] -= 0.5 * step.dt * x[0][i];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("undeclared_coupling", "1.0.0", registry) { registry.add<Animal>(); }
