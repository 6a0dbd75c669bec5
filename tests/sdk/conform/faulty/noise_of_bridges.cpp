// SPDX-License-Identifier: Apache-2.0
// Says that it is time-invariant, and a step that bridges a hole has twice the noise.
// fails: numbers.process.time_invariant
#include "faulty.hpp"

namespace faulty::noise_of_bridges {

class Subject final : public Process {
 public:
  explicit Subject(const Binding& binding) : Process(binding) { declaration_.time_invariant(); }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (const auto handle : {q_pp, q_vv, q_pv})
      if (double* const block = diagonal(out.Qd, handle); block && in.step.bridges)
        for (int i = 0; i < 2; ++i) block[i] *= 2;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("noise_of_bridges")); }

}  // namespace faulty::noise_of_bridges
