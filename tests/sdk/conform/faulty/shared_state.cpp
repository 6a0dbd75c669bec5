// SPDX-License-Identifier: Apache-2.0
// All instances share a cache: what one computed for its time another uses for its own.
// fails: life.interleaved
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    static double last_dt = -1, last_q = 0;
    if (last_dt != in.step.dt) last_dt = in.step.dt, last_q = q;
    for (int i = 0; i < 2; ++i) set(out.Qd, q_vv, i, last_q * in.step.dt);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("shared_state", "1.0.0", registry) { registry.add<Subject>(); }
