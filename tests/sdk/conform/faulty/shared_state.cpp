// SPDX-License-Identifier: Apache-2.0
// All instances share a cache: what one computed for its time another uses for its own.
// fails: life.interleaved
#include "faulty.hpp"

namespace faulty::shared_state {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    static double last_dt = -1, last_q = 0;
    if (last_dt != in.step.dt) last_dt = in.step.dt, last_q = q;
    for (int i = 0; i < 2; ++i) set(out.Qd, q_vv, i, last_q * in.step.dt);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("shared_state")); }

}  // namespace faulty::shared_state
