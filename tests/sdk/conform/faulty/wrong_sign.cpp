// SPDX-License-Identifier: Apache-2.0
// Phi has the wrong sign.
// fails: numbers.process.jacobian
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  using Process::Process;
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte* memory,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const auto result = Process::propagate(step, x, memory, out);
    for (int i = 0; i < 2; ++i) out.transition[0][i] = -out.transition[0][i];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_sign", "1.0.0", registry) { registry.add<Animal>(); }
