// SPDX-License-Identifier: Apache-2.0
// Writes one number beyond its block of Phi.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (double* block = diagonal(out.phi, phi_pv)) block[2] = 0;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_beyond", "1.0.0", registry) { registry.add<Subject>(); }
