// SPDX-License-Identifier: Apache-2.0
// Phi has the wrong sign.
// fails: numbers.process.jacobian
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (double* block = diagonal(out.phi, phi_pv)) block[0] = -block[0], block[1] = -block[1];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_sign", "1.0.0", registry) { registry.add<Subject>(); }
