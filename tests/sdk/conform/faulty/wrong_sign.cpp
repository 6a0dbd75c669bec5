// SPDX-License-Identifier: Apache-2.0
// Phi has the wrong sign.
// fails: numbers.process.jacobian
#include "faulty.hpp"

namespace faulty::wrong_sign {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (double* block = diagonal(out.phi, phi_pv)) block[0] = -block[0], block[1] = -block[1];
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_sign")); }

}  // namespace faulty::wrong_sign
