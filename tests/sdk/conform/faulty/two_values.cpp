// SPDX-License-Identifier: Apache-2.0
// Gives another value when no Jacobian is wanted.
// fails: numbers.derived.value
#include "faulty.hpp"

namespace faulty::two_values {

class Subject final : public Derived {
 public:
  using Derived::Derived;
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    const auto result = Derived::evaluate(in, out);
    if (!out.J) out.value[0] = in.x[p][0];
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("two_values")); }

}  // namespace faulty::two_values
