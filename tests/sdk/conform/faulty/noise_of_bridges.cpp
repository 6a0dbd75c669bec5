// SPDX-License-Identifier: Apache-2.0
// Says that it is time-invariant, and a step that bridges a hole has twice the noise.
// fails: numbers.process.time_invariant
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) { declaration_.time_invariant(); }
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (const auto handle : {q_pp, q_vv, q_pv})
      if (double* const block = diagonal(out.Qd, handle); block && in.step.bridges)
        for (int i = 0; i < 2; ++i) block[i] *= 2;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("noise_of_bridges", "1.0.0", registry) { registry.add<Subject>(); }
