// SPDX-License-Identifier: Apache-2.0
// Its noise grows with the square of time.
// fails: numbers.process.composition
#include "faulty.hpp"

namespace faulty::noise_by_square {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (int i = 0; i < 2; ++i) {
      set(out.Qd, q_pp, i, 0);
      set(out.Qd, q_vv, i, q * in.step.dt * in.step.dt);
      set(out.Qd, q_pv, i, 0);
    }
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("noise_by_square")); }

}  // namespace faulty::noise_by_square
