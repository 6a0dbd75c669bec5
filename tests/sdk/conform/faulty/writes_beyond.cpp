// SPDX-License-Identifier: Apache-2.0
// Writes one number beyond its block of Phi.
// fails: life.calls
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    out.transition[0][2] = 0;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("writes_beyond", "1.0.0", registry) { registry.add<Animal>(); }
