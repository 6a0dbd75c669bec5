// SPDX-License-Identifier: Apache-2.0
// Makes noise in no time.
// fails: numbers.process.rest
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    if (step.dt == 0) out.noise[1][0] = 1e-9;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("moves_at_rest", "1.0.0", registry) { registry.add<Animal>(); }
