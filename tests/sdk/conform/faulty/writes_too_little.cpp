// SPDX-License-Identifier: Apache-2.0
// Leaves one number of Qd unwritten.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const double kept = out.noise[1][1];
    const auto result = Process::propagate(step, x, memory, out);
    out.noise[1][1] = kept;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_too_little", "1.0.0", registry) { registry.add<Animal>(); }
