// SPDX-License-Identifier: Apache-2.0
// Never comes back from propagate().
// fails: life.calls timeout
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    for (volatile bool for_ever = true; for_ever;) {
    }
    const auto result = Process::propagate(in, out);
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("never_returns", "1.0.0", registry) { registry.add<Subject>(); }
