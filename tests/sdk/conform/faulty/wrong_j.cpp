// SPDX-License-Identifier: Apache-2.0
// J leaves out how the plane is bent.
// fails: numbers.derived.jacobian
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Derived {
 public:
  using Derived::Derived;
  binnacle::Result evaluate(const double* const* x, const binnacle::legacy::Context& context, double* value,
                            const binnacle::MatrixView* J) const override {
    const auto result = Derived::evaluate(x, context, value, J);
    if (J) J[0](0, 1) = 0;
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_j", "1.0.0", registry) { registry.add<Animal>(); }
