// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: over dt = 0 its Phi is the identity but for rounding, as that of a turn by sine and cosine is.
// fails: nothing
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) {
    declared.transition = {{0, 0, binnacle::Structure::diagonal}, {0, 1, binnacle::Structure::diagonal}};
  }
  binnacle::Result propagate(const binnacle::Step& step, const double* const* x, std::byte*,
                             const binnacle::legacy::ProcessOutput& out) const override {
    const double dt = step.dt;
    for (int i = 0; i < 2; ++i) {
      out.x_plus[0][i] = x[0][i] + x[1][i] * dt;
      out.x_plus[1][i] = x[1][i];
      out.transition[0][i] = 1 + 4 * std::numeric_limits<double>::epsilon();
      out.transition[1][i] = dt;
      out.noise[0][i] = q * dt * dt * dt / 3;
      out.noise[1][i] = q * dt;
      out.noise[2][i] = q * dt * dt / 2;
    }
    return binnacle::Result::ok();
  }
};

}  // namespace

BINNACLE_PLUGIN("rounds_at_rest", "1.0.0", registry) { registry.add<Subject>(); }
