// SPDX-License-Identifier: Apache-2.0
// Gives another value when no Jacobian is wanted.
// fails: numbers.derived.value
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Derived {
 public:
  using Derived::Derived;
  binnacle::Result evaluate(const binnacle::DerivedInput& in, binnacle::DerivedOutput& out) const override {
    const auto result = Derived::evaluate(in, out);
    if (!out.J) out.value[0] = in.x[p][0];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("two_values", "1.0.0", registry) { registry.add<Subject>(); }
