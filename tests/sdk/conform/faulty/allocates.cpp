// SPDX-License-Identifier: Apache-2.0
// Allocates in every call.
// fails: speed.allocations warn
#include "faulty.hpp"

namespace faulty::allocates {

class Subject final : public Process {
 public:
  using Process::Process;
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    char* volatile block = new char[100];
    delete[] block;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("allocates")); }

}  // namespace faulty::allocates
