// SPDX-License-Identifier: Apache-2.0
// P itself, symmetric to the bit, updated by Joseph's form.
#pragma once

#include <vector>

#include "filter/covariance_form.hpp"
#include "filter/layout.hpp"

namespace binnacle::filter {

class Joseph final : public CovarianceForm {
 public:
  /// P: padded(n)×n, column-major. `most_dof`: of a block that is transformed.
  Joseph(const TransitionPlan& plan, int most_dof, double* P)
      : plan_(plan),
        P_(P),
        predict_scratch_(predict_scratch(plan)),
        transform_scratch_(as_size(padded(plan.n)) * as_size(most_dof)) {}

  void set(MatrixView P) override { view().as() = P.as(); }
  void predict(const double* const* phi, const double* const* noise) override {
    filter::predict(plan_, phi, noise, P_, predict_scratch_.data());
  }
  void project(const std::vector<int>& columns, int m, const UpdateWork& work) const override {
    filter::project(columns, P_, plan_.n, m, work);
  }
  void correct(int m, const UpdateWork& work) override { filter::correct(P_, plan_.n, m, work); }
  void transform(const double* T, int first, int d) override {
    transform_block(T, first, d, P_, plan_.n, transform_scratch_.data());
  }
  void inflate(int row, double variance) override { view()(row, row) += variance; }
  double variance(int row) const override { return view()(row, row); }
  int first_unsound(double bound) const override {
    const int step = padded(plan_.n) + 1;
    for (int i = 0; i < plan_.n; ++i)
      if (!(P_[i * step] >= 0 && P_[i * step] < bound)) return i;
    return -1;
  }
  void expand(MatrixView into) const override { into.as() = view().as(); }
  MatrixView view() const override { return {P_, plan_.n, plan_.n, padded(plan_.n)}; }

 private:
  const TransitionPlan& plan_;
  double* P_;
  std::vector<double> predict_scratch_, transform_scratch_;
};

}  // namespace binnacle::filter
