// SPDX-License-Identifier: Apache-2.0
// What the forms share that keep P as a factor: the arithmetic is rotations of weighted columns, so P cannot become
// indefinite, and its square root is never squared.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/aligned.hpp"
#include "filter/covariance_form.hpp"

namespace binnacle::internal::filter {

/// P = C W Cᵀ, C upper triangular, W diagonal. In memory lies C, padded(n)×n, and behind it whatever else the form keeps.
///
/// Whatever a step or an update makes of P is a sum Σ w c cᵀ over more columns than n; triangularize() makes n of them by
/// rotations of two at a time. A column that has a zero in the row at work needs none, so the cost follows the couplings.
class FactoredForm : public CovarianceForm {
 public:
  int set(ConstMatrixView P) override;
  int predict(const double* const* phi, const double* const* noise) override;
  void project(const std::vector<int>& columns, const UpdateWork& work) const override;
  const char* factor(const std::vector<int>& columns, const UpdateWork& work) override;
  void gain(const std::vector<unsigned char>& corrected, const UpdateWork& work) const override;
  void correct(const std::vector<unsigned char>& corrected, const UpdateWork& work) override;
  void transform(const double* T, int first, int d) override;
  void inflate(int row, double variance) override;
  void scale(const double* d) override;
  double variance(int row) const override;
  void variances(const std::vector<int>& rows, double* into) const override;
  bool is_below(double limit) const override;
  ConstMatrixView expand() const override;

 protected:
  FactoredForm(const TransitionPlan& plan, CovarianceKind kind, int max_rows, double* memory);

  /// Of a factor that lies in `memory`; null where all are 1.
  virtual const double* weights(const double* memory) const = 0;
  /// Column j becomes √w x, or x with the weight w, where x is 1 in row j and zero below it.
  virtual void put(int j, const double* x, double w) = 0;
  /// Rotates the columns `others` into the column x so that they are zero in row j; puts x and takes nothing below that row.
  virtual void eliminate(int j, int x, std::span<const int> others) = 0;
  /// Bierman's or Carlson's update of the factor in `memory` by a scalar of variance r, f = Cᵀ h. Returns α = hᵀ P h + r and
  /// k = P h; what it makes of the factor holds for α > 0 only.
  virtual double update(double* memory, const double* f, double r, double* k) const = 0;

  double* column(int k) { return column_at(columns_.data(), ld_, k); }
  double weight_of(const double* weights, int k) const { return weights ? weights[k] : 1.0; }

  const int n_, ld_;
  double* const memory_;
  base::AlignedVector<double> columns_;  // ld × (n + most): what triangularize() works on
  std::vector<double> weights_;          // of each

 private:
  struct NoiseGroup {
    std::vector<int> rows;  // of P, coupled through Qd, ascending
    std::size_t first = 0;  // of its square in noise_
  };

  void group_noise();
  double* add(double weight);
  void load();
  void triangularize();
  int add_noise_columns(const double* const* noise);
  void propagate_columns(const double* const* phi);
  void whiten(int columns, const UpdateWork& work);
  void project_factor(const double* memory, const double* h, int stride, const std::vector<int>& columns,
                      double* f) const;

  const TransitionPlan& plan_;
  const std::size_t doubles_;
  int count_ = 0;  // of columns_
  std::vector<int> active_;

  // A step
  std::vector<NoiseGroup> noise_groups_;
  std::vector<std::size_t> noise_places_;  // of plan.noise_elements in noise_
  std::vector<double> noise_, noise_variances_;
  base::AlignedVector<double> rows_, products_, coefficients_;  // C transposed; rows of Φ C

  // An update: of what was factored last
  base::AlignedVector<double> updated_;  // as memory_
  base::AlignedVector<double> gains_;    // ld × max_rows: of each whitened row by itself
  std::vector<double> alpha_, M_, R_, variances_, whitened_, f_;

  mutable base::AlignedVector<double> P_, made_of_;  // what expand() made, and of which memory
  mutable std::vector<double> sums_;
};

/// P = U D Uᵀ, U unit upper triangular, D behind it. A variance of zero is a zero in D, and no square root is ever taken.
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

/// P = S Sᵀ, S upper triangular, its diagonal not negative.
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
