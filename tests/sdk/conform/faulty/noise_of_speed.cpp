// SPDX-License-Identifier: Apache-2.0
// Says that it is time-invariant, and its noise grows with the velocity.
// fails: numbers.process.time_invariant
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) { declaration_.time_invariant(); }
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (const auto handle : {q_pp, q_vv, q_pv})
      if (double* const block = diagonal(out.Qd, handle))
        for (int i = 0; i < 2; ++i) block[i] *= 1 + 0.01 * in.x[v][0] * in.x[v][0];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("noise_of_speed", "1.0.0", registry) { registry.add<Subject>(); }
