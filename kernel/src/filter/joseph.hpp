// SPDX-License-Identifier: Apache-2.0
// P itself, symmetric to the bit, updated by Joseph's form.
#pragma once

#include <vector>

#include "filter/covariance_form.hpp"

namespace binnacle::filter {

class Joseph final : public CovarianceForm {
 public:
  /// P: padded(n)×n, column-major. `most_dof`: of a block that is transformed.
  Joseph(const TransitionPlan& plan, int most_dof, double* P);

  void set(MatrixView P) override;
  void predict(const double* const* phi, const double* const* noise) override;
  void project(const UpdateColumns& columns, int m, const UpdateWork& work) const override;
  void correct(int m, const UpdateWork& work) override;
  void transform(const double* T, int first, int d) override;
  void inflate(int row, double variance) override;
  double variance(int row) const override;
  int first_unsound(double bound) const override;
  void expand(MatrixView into) const override;
  MatrixView view() const override;

 private:
  const TransitionPlan& plan_;
  double* P_;
  std::vector<double> predict_scratch_, transform_scratch_;
};

}  // namespace binnacle::filter
