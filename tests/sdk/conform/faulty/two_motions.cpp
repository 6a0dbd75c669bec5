// SPDX-License-Identifier: Apache-2.0
// Moves the position otherwise when no Phi is wanted.
// fails: numbers.process.value
#include "faulty.hpp"

namespace faulty::two_motions {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (!out.phi) out.x[p][1] = in.x[p][1];
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("two_motions")); }

}  // namespace faulty::two_motions
