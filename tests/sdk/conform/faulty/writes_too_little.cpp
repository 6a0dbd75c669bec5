// SPDX-License-Identifier: Apache-2.0
// Leaves one number of Qd unwritten.
// fails: life.calls
#include "faulty.hpp"

namespace faulty::writes_too_little {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    double* variance = diagonal(out.Qd, q_vv);
    const double kept = variance ? variance[1] : 0;
    const auto result = Process::propagate(in, out);
    if (variance) variance[1] = kept;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("writes_too_little")); }

}  // namespace faulty::writes_too_little
