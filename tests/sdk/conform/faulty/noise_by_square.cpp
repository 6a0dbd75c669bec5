// SPDX-License-Identifier: Apache-2.0
// Its noise grows with the square of time.
// fails: numbers.process.composition
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    for (int i = 0; i < 2; ++i) {
      out.noise[0][i] = 0;
      out.noise[1][i] = q * step.dt * step.dt;
      out.noise[2][i] = 0;
    }
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("noise_by_square", "1.0.0", registry) { registry.add<Animal>(); }
