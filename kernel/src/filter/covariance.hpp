// SPDX-License-Identifier: Apache-2.0
// Joseph's form of the covariance on a full symmetric matrix, which keeps P exactly symmetric, allocates nothing and does no
// arithmetic on what the declared sparsity says is zero.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/aligned.hpp"
#include "binnacle/eigen.hpp"
#include "filter/covariance_form.hpp"

namespace binnacle::internal::filter {

/// P itself, symmetric to the bit, updated by Joseph's form.
class Joseph final : public CovarianceForm {
 public:
  /// P: padded(n)×n, column-major. `most_dof`: of a block that is transformed.
  Joseph(const TransitionPlan& plan, int most_dof, double* P);

  int set(ConstMatrixView P) override {
    matrix().as() = P.as();
    return -1;
  }
  int predict(const double* const* phi, const double* const* noise) override;
  void project(const std::vector<int>& columns, const UpdateWork& work) const override;
  const char* factor(const std::vector<int>& columns, const UpdateWork& work) override;
  void gain(const std::vector<unsigned char>& corrected, const UpdateWork& work) const override;
  void correct(const std::vector<unsigned char>& corrected, const UpdateWork& work) override;
  std::span<const int> rounded() const override { return rounded_; }
  void transform(const double* T, int first, int d) override;
  void inflate(int row, double variance) override { matrix()(row, row) += variance; }
  void scale(const double* d) override;
  double variance(int row) const override { return matrix()(row, row); }
  void variances(const std::vector<int>& rows, double* into) const override {
    for (const int row : rows) *into++ = matrix()(row, row);
  }
  bool is_below(double limit) const override {
    // As integers, numbers that are not negative are in the same order, and all others are beyond them.
    std::uint64_t greatest = 0;
    const std::ptrdiff_t next = ld_ + 1;
    for (const double *variance = P_, *const end = P_ + plan_.n * next; variance != end; variance += next)
      greatest = std::max(greatest, std::bit_cast<std::uint64_t>(*variance));
    return greatest < std::bit_cast<std::uint64_t>(limit) || is_below_but_for_zeros(limit);
  }
  ConstMatrixView expand() const override { return matrix(); }

 private:
  MatrixView matrix() const { return {P_, plan_.n, plan_.n, ld_}; }
  void predict_coupled(const double* const* phi);
  bool is_below_but_for_zeros(double limit) const;
  template <class Before>
  void settle_variances(int first, int end, const Before& before);

  const TransitionPlan& plan_;
  double* P_;
  int ld_, ld_coupled_;
  // With A the coupled rows (dense groups). Columns of M behind the coupled ones go into rows of Mt that nobody reads.
  base::AlignedVector<double> M_;             // ld × coupled: P Φ_Aᵀ
  base::AlignedVector<double> Mt_;            // ld_coupled × ld: Mᵀ
  base::AlignedVector<double> PAA_;           // ld_coupled × coupled; unused where P'_AA is written in place
  base::AlignedVector<double> d_;             // ld: diagonal of Φ, 1 for coupled rows
  base::AlignedVector<double> coefficients_;  // of groups that do not have them in one run, one after the other
  std::vector<CombinedRows> groups_;
  bool is_coupled_first_ = false;            // A is one run from row 0 on
  base::AlignedVector<double> transformed_;  // ld × most_dof
  std::vector<int> rows_;                    // 0, 1, 2, …
  std::vector<double> before_;               // most_dof: variances before a transformation
  std::vector<int> rounded_;
};

}  // namespace binnacle::internal::filter
