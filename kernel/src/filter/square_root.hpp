// SPDX-License-Identifier: Apache-2.0
// P = S Sᵀ: Carlson's update, and a step by Givens rotations.
#pragma once

#include "filter/factored_form.hpp"

namespace binnacle::internal::filter {

/// S upper triangular, its diagonal not negative.
class SquareRoot final : public FactoredForm {
 public:
  SquareRoot(const TransitionPlan& plan, int max_rows, double* memory)
      : FactoredForm(plan, CovarianceKind::square_root, max_rows, memory) {}

 private:
  const double* weights(const double*) const override { return nullptr; }
  void put(int j, const double* x, double w) override;
  void eliminate(int j, int x, std::span<const int> others) override;
  double update(double* memory, const double* f, double r, double* k) const override;
};

}  // namespace binnacle::internal::filter
