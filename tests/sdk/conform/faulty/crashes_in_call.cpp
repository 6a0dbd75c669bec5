// SPDX-License-Identifier: Apache-2.0
// Dies in propagate().
// fails: life.calls crash
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    volatile int* nowhere = nullptr;
    *nowhere = 1;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("crashes_in_call", "1.0.0", registry) { registry.add<Subject>(); }
