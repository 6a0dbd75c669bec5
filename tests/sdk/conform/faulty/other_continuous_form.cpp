// SPDX-License-Identifier: Apache-2.0
// Its continuous form has twice the noise of its closed one.
// fails: numbers.process.discretization
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Process {
 public:
  explicit Animal(const binnacle::Binding& binding) : Process(binding) { declared.has_continuous_form = true; }
  void linearized(const double* const*, const binnacle::legacy::ContinuousOutput& out) const override {
    for (int i = 0; i < 2; ++i) {
      out.dynamics[0][i] = 1;
      out.noise[0][i] = 0;
      out.noise[1][i] = 2 * q;
      out.noise[2][i] = 0;
    }
  }
};

}  // namespace

BINNACLE_PLUGIN("other_continuous_form", "1.0.0", registry) { registry.add<Animal>(); }
