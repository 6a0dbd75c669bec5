// SPDX-License-Identifier: Apache-2.0
// Writes one number beyond its block of Phi.
// fails: life.calls
#include "faulty.hpp"

namespace faulty::writes_beyond {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (double* block = diagonal(out.phi, phi_pv)) block[2] = 0;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("writes_beyond")); }

}  // namespace faulty::writes_beyond
