// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: over dt = 0 its Phi is the identity but for rounding, as that of a turn by sine and cosine is.
// fails: nothing
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) {
    phi_pp_ = declaration_.couples(p, p, binnacle::Structure::diagonal);
  }
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (int i = 0; i < 2; ++i) set(out.phi, phi_pp_, i, 1 + 4 * std::numeric_limits<double>::epsilon());
    return result;
  }

 private:
  binnacle::PhiBlock phi_pp_;
};

}  // namespace

BINNACLE_PLUGIN("rounds_at_rest", "1.0.0", registry) { registry.add<Subject>(); }
