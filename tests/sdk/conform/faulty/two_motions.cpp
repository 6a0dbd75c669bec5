// SPDX-License-Identifier: Apache-2.0
// Moves the position otherwise when no Phi is wanted.
// fails: numbers.process.value
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    if (!out.phi) out.x[p][1] = in.x[p][1];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("two_motions", "1.0.0", registry) { registry.add<Subject>(); }
