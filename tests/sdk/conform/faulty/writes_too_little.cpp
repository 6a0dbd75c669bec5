// SPDX-License-Identifier: Apache-2.0
// Leaves one number of Qd unwritten.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    double* variance = diagonal(out.Qd, q_vv);
    const double kept = variance ? variance[1] : 0;
    const auto result = Process::propagate(in, out);
    if (variance) variance[1] = kept;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_too_little", "1.0.0", registry) { registry.add<Subject>(); }
