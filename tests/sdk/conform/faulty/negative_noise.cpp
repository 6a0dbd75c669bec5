// SPDX-License-Identifier: Apache-2.0
// Position and velocity noise are correlated by more than one.
// fails: numbers.process.noise
#include "faulty.hpp"

namespace faulty::negative_noise {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (double* cross = diagonal(out.Qd, q_pv)) cross[0] *= 4, cross[1] *= 4;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("negative_noise")); }

}  // namespace faulty::negative_noise
