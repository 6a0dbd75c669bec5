// SPDX-License-Identifier: Apache-2.0
// Says that it is time-invariant, and its noise grows with the velocity.
// fails: numbers.process.time_invariant
#include "faulty.hpp"

namespace faulty::noise_of_speed {

class Subject final : public Process {
 public:
  explicit Subject(const Binding& binding) : Process(binding) { declaration_.time_invariant(); }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (const auto handle : {q_pp, q_vv, q_pv})
      if (double* const block = diagonal(out.Qd, handle))
        for (int i = 0; i < 2; ++i) block[i] *= 1 + 0.01 * in.x[v][0] * in.x[v][0];
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("noise_of_speed")); }

}  // namespace faulty::noise_of_speed
