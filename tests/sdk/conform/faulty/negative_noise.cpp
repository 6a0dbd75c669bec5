// SPDX-License-Identifier: Apache-2.0
// Position and velocity noise are correlated by more than one.
// fails: numbers.process.noise
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    for (int i = 0; i < 2; ++i) out.noise[2][i] *= 4;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("negative_noise", "1.0.0", registry) { registry.add<Animal>(); }
