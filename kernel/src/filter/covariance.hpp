// SPDX-License-Identifier: Apache-2.0
// The covariance of a filter: what an estimator asks of it, and Joseph's form on a full symmetric matrix, which
// keeps P exactly symmetric, allocates nothing and does no arithmetic on what the declared sparsity says is zero.
#pragma once

#include <cstddef>
#include <vector>

#include "base/aligned.hpp"
#include "binnacle/view.hpp"
#include "filter/strip_loops.hpp"

namespace binnacle::internal::filter {

/// A few rows of Φ (or H) that share their non-zero columns. `coefficients` of column c of the list begin at
/// `block[c.block] + c.offset`, one per row of the group.
struct RowGroup {
  struct Column {
    int column = 0;  // of P
    int block = 0;   // index into the table of block pointers
    int offset = 0;  // of the group's first row in that block, doubles
  };
  int first_row = 0;  // of P
  int rows = 0;       // 1…3
  std::vector<Column> columns;
  std::vector<int> indices;  // columns[c].column, close together; filled by finish()
};

/// Neighbouring rows of P of one kind; `position`: of the first among all rows of that kind.
struct RowRun {
  int first = 0;
  int count = 0;
  int position = 0;
  int end() const { return first + count; }
};

/// The structure of one Φ and Qd, fixed when the filter is composed.
struct TransitionPlan {
  struct Diagonal {
    int row = 0;
    int block = 0;
    int offset = 0;
  };
  struct Noise {
    int row = 0;     // first row in P
    int column = 0;  // first column in P
    int rows = 0;
    int columns = 0;
    int stride = 0;  // of the block; 0: a diagonal block, one double per row
    int block = 0;   // index into the table of noise block pointers
  };
  /// An element of Qd on or below the diagonal: where in P, and where in which block.
  struct NoiseElement {
    int at = 0;
    int block = 0;
    int place = 0;
  };
  int n = 0;
  std::vector<RowGroup> groups;     // rows of Φ with off-diagonal or dense content
  std::vector<Diagonal> diagonals;  // rows of Φ with nothing but a diagonal element
  std::vector<RowRun> coupled;      // rows of P that some group writes, ascending
  std::vector<RowRun> uncoupled;    // all others, ascending
  int coupled_rows = 0;
  int scaled_rows = 0;  // behind the last of `diagonals`
  std::vector<Noise> noise;
  std::vector<NoiseElement> noise_elements;
};

/// Fills `coupled`, `uncoupled`, `scaled_rows` and `noise_elements` from the rest.
void finish(TransitionPlan& plan);

/// Φ and Qd of the tables of block pointers, n×n.
void expand_transition(const TransitionPlan& plan, const double* const* phi, MatrixView Phi);
void expand_noise(const TransitionPlan& plan, const double* const* noise, MatrixView Qd);

/// S = HPHt + R and its factor; false when S is not positive definite.
bool factor_innovation(const UpdateWork& work);
/// rᵀ S⁻¹ r, the normalized innovation squared.
double normalized_innovation_squared(const UpdateWork& work);
/// K = G S⁻¹, with rows of K zeroed where `corrected[row]` is 0 (Schmidt); `corrected` empty: none.
void gain(const std::vector<unsigned char>& corrected, int n, const UpdateWork& work);
/// delta = K r, padded(n) doubles.
void gain_times_residual(int n, const UpdateWork& work, double* delta);

/// P of n rows. Nobody else touches its memory, which lies in the arena and is all that a form remembers.
class CovarianceForm {
 public:
  virtual ~CovarianceForm() = default;

  /// P: n×n.
  virtual void set(ConstMatrixView P) = 0;
  /// P ← Φ P Φᵀ + Qd, by tables of block pointers.
  virtual void predict(const double* const* phi, const double* const* noise) = 0;
  /// work.G = P Hᵀ and work.HPHt = H G; `columns` of P are those of work.H.
  virtual void project(const std::vector<int>& columns, const UpdateWork& work) const = 0;
  /// P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ with work.K, in which rows of considered components are zero, and work.G and S.
  virtual void correct(const UpdateWork& work) = 0;
  /// P ← T P Tᵀ, where T is the identity but for a d×d block (column-major) at row `first`.
  virtual void transform(const double* T, int first, int d) = 0;
  /// Adds a variance to one component.
  virtual void inflate(int row, double variance) = 0;
  /// P ← D P D, D = diag(d).
  virtual void scale(const double* d) = 0;
  /// Of one component.
  virtual double variance(int row) const = 0;
  /// Of these components.
  virtual void variances(const std::vector<int>& rows, double* into) const = 0;
  /// P, whole, to be read until it changes.
  virtual ConstMatrixView expand() const = 0;
};

/// P itself, symmetric to the bit, updated by Joseph's form.
class Joseph final : public CovarianceForm {
 public:
  /// P: padded(n)×n, column-major. `most_dof`: of a block that is transformed.
  Joseph(const TransitionPlan& plan, int most_dof, double* P);

  void set(ConstMatrixView P) override { matrix().as() = P.as(); }
  void predict(const double* const* phi, const double* const* noise) override;
  void project(const std::vector<int>& columns, const UpdateWork& work) const override;
  void correct(const UpdateWork& work) override;
  void transform(const double* T, int first, int d) override;
  void inflate(int row, double variance) override { matrix()(row, row) += variance; }
  void scale(const double* d) override;
  double variance(int row) const override { return matrix()(row, row); }
  void variances(const std::vector<int>& rows, double* into) const override {
    for (const int row : rows) *into++ = matrix()(row, row);
  }
  ConstMatrixView expand() const override { return matrix(); }

 private:
  MatrixView matrix() const { return {P_, plan_.n, plan_.n, ld_}; }
  void predict_coupled(const double* const* phi);
  void store_coupled();
  void scale_uncoupled();

  const TransitionPlan& plan_;
  double* P_;
  int ld_, ld_coupled_;
  // With A the coupled rows (dense groups). Columns of M behind the coupled ones go into rows of Mt that nobody reads.
  base::AlignedVector<double> M_;             // ld × coupled: P Φ_Aᵀ
  base::AlignedVector<double> Mt_;            // ld_coupled × ld: Mᵀ
  base::AlignedVector<double> PAA_;           // ld_coupled × coupled
  base::AlignedVector<double> d_;             // ld: diagonal of Φ, 1 for coupled rows
  base::AlignedVector<double> coefficients_;  // of all groups, one after the other
  base::AlignedVector<double> transformed_;   // ld × most_dof
  std::vector<int> rows_;                     // 0, 1, 2, …
};

}  // namespace binnacle::internal::filter
