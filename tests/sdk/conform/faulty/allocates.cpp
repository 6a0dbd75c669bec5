// SPDX-License-Identifier: Apache-2.0
// Allocates in every call.
// fails: speed.allocations warn
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    char* volatile block = new char[100];
    delete[] block;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("allocates", "1.0.0", registry) { registry.add<Subject>(); }
