// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: over dt = 0 its Phi is the identity but for rounding, as that of a turn by sine and cosine is.
// fails: nothing
#include "faulty.hpp"

namespace faulty::rounds_at_rest {

class Subject final : public Process {
 public:
  explicit Subject(const Binding& binding) : Process(binding) {
    phi_pp_ = declaration_.couples(p, p, Structure::diagonal);
  }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const auto result = Process::propagate(in, out);
    for (int i = 0; i < 2; ++i) set(out.phi, phi_pp_, i, 1 + 4 * std::numeric_limits<double>::epsilon());
    return result;
  }

 private:
  PhiBlock phi_pp_;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("rounds_at_rest")); }

}  // namespace faulty::rounds_at_rest
