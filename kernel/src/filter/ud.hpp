// SPDX-License-Identifier: Apache-2.0
// P = U D Uᵀ: Bierman's update, and Thornton's step with rotations.
#pragma once

#include "filter/factored_form.hpp"

namespace binnacle::internal::filter {

/// U unit upper triangular, D behind it. A variance of zero is a zero in D, and no square root is ever taken.
class Ud final : public FactoredForm {
 public:
  Ud(const TransitionPlan& plan, int max_rows, double* memory)
      : FactoredForm(plan, CovarianceKind::ud, max_rows, memory) {}

 private:
  const double* weights(const double* memory) const override { return column_at(memory, ld_, n_); }
  void put(int j, const double* x, double w) override;
  void eliminate(int j, int x, std::span<const int> others) override;
  double update(double* memory, const double* f, double r, double* k) const override;
};

}  // namespace binnacle::internal::filter
