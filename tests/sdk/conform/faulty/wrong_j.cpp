// SPDX-License-Identifier: Apache-2.0
// J leaves out how the plane is bent.
// fails: numbers.derived.jacobian
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Derived {
 public:
  using Derived::Derived;
  binnacle::Result evaluate(const binnacle::DerivedInput& in, binnacle::DerivedOutput& out) const override {
    const auto result = Derived::evaluate(in, out);
    if (const auto J = out.J[p]) J(0, 1) = 0;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_j", "1.0.0", registry) { registry.add<Subject>(); }
