// SPDX-License-Identifier: Apache-2.0
// Never comes back from propagate().
// fails: life.calls timeout
#include <unistd.h>

#include "faulty.hpp"

namespace faulty::never_returns {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    for (volatile bool for_ever = true; for_ever;) ::pause();  // costs no processor time
    const auto result = Process::propagate(in, out);
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("never_returns")); }

}  // namespace faulty::never_returns
