// SPDX-License-Identifier: Apache-2.0
// Makes noise in no time.
// fails: numbers.process.rest
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (in.step.dt == 0) set(out.Qd, q_vv, 0, 1e-9);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("moves_at_rest", "1.0.0", registry) { registry.add<Subject>(); }
