// SPDX-License-Identifier: Apache-2.0
// Its noise grows with the square of time.
// fails: numbers.process.composition
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (int i = 0; i < 2; ++i) {
      set(out.Qd, q_pp, i, 0);
      set(out.Qd, q_vv, i, q * in.step.dt * in.step.dt);
      set(out.Qd, q_pv, i, 0);
    }
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("noise_by_square", "1.0.0", registry) { registry.add<Subject>(); }
