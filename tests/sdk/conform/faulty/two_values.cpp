// SPDX-License-Identifier: Apache-2.0
// Gives another value when no Jacobian is wanted.
// fails: numbers.derived.value
#include "faulty.hpp"

namespace {

class Animal final : public faulty::Derived {
 public:
  using Derived::Derived;
  binnacle::Result evaluate(const double* const* x, const binnacle::legacy::Context& context, double* value,
                            const binnacle::MatrixView* J) const override {
    const auto result = Derived::evaluate(x, context, value, J);
    if (!J) value[0] = x[0][0];
    return result;
  }
};

}  // namespace

BINNACLE_PLUGIN("two_values", "1.0.0", registry) { registry.add<Animal>(); }
