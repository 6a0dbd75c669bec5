// SPDX-License-Identifier: Apache-2.0
// Its continuous form has twice the noise of its closed one.
// fails: numbers.process.discretization
#include "faulty.hpp"

namespace faulty::other_continuous_form {

class Subject final : public Process {
 public:
  explicit Subject(const Binding& binding) : Process(binding) { declaration_.has_both_forms(); }
  void linearized(const ContinuousInput&, ContinuousOutput& out) const override {
    for (int i = 0; i < 2; ++i) {
      set(out.F, phi_pv, i, 1);
      set(out.GQGt, q_pp, i, 0);
      set(out.GQGt, q_vv, i, 2 * q);
      set(out.GQGt, q_pv, i, 0);
    }
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("other_continuous_form")); }

}  // namespace faulty::other_continuous_form
