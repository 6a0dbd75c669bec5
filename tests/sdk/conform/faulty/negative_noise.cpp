// SPDX-License-Identifier: Apache-2.0
// Position and velocity noise are correlated by more than one.
// fails: numbers.process.noise
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (double* cross = diagonal(out.Qd, q_pv)) cross[0] *= 4, cross[1] *= 4;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("negative_noise", "1.0.0", registry) { registry.add<Subject>(); }
