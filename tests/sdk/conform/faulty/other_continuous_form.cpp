// SPDX-License-Identifier: Apache-2.0
// Its continuous form has twice the noise of its closed one.
// fails: numbers.process.discretization
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Process {
 public:
  explicit Subject(const binnacle::Binding& binding) : Process(binding) { declaration_.has_both_forms(); }
  void linearized(const binnacle::ContinuousInput&, binnacle::ContinuousOutput& out) const override {
    for (int i = 0; i < 2; ++i) {
      set(out.F, phi_pv, i, 1);
      set(out.GQGt, q_pp, i, 0);
      set(out.GQGt, q_vv, i, 2 * q);
      set(out.GQGt, q_pv, i, 0);
    }
  }
};

}  // namespace

BINNACLE_PLUGIN("other_continuous_form", "1.0.0", registry) { registry.add<Subject>(); }
