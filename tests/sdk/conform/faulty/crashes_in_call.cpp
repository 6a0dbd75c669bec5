// SPDX-License-Identifier: Apache-2.0
// Dies in propagate().
// fails: life.calls crash
#include "faulty.hpp"

namespace faulty::crashes_in_call {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    volatile int* nowhere = nullptr;
    *nowhere = 1;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("crashes_in_call")); }

}  // namespace faulty::crashes_in_call
