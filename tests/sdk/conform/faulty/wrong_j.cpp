// SPDX-License-Identifier: Apache-2.0
// J leaves out how the plane is bent.
// fails: numbers.derived.jacobian
#include "faulty.hpp"

namespace faulty::wrong_j {

class Subject final : public Derived {
 public:
  using Derived::Derived;
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    const auto result = Derived::evaluate(in, out);
    if (const auto J = out.J[p]) J(0, 1) = 0;
    return result;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_j")); }

}  // namespace faulty::wrong_j
