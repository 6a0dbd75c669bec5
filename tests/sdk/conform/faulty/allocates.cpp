// SPDX-License-Identifier: Apache-2.0
// Allocates in every call.
// fails: speed.allocations warn
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    char* volatile block = new char[100];
    delete[] block;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("allocates", "1.0.0", registry) { registry.add<Animal>(); }
