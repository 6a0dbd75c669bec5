// SPDX-License-Identifier: Apache-2.0
// What an estimator asks of the covariance of a filter, in whichever form it is kept; and the structure of a step.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

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
  std::vector<int> indices;    // columns[c].column, close together; filled by finish()
  bool is_in_one_run = false;  // the coefficients of each column lie behind those of the one before
};

/// 0, step, 2 step …: of the rows of a whole dense block, or of its columns by their stride.
inline std::vector<int> places(int count, int step = 1) {
  std::vector<int> all;
  for (int i = 0; i < count; ++i) all.push_back(i * step);
  return all;
}

/// The structure of one Φ and Qd, fixed when the filter is composed.
struct TransitionPlan {
  struct Diagonal {
    int row = 0;
    int block = 0;
    int offset = 0;
  };
  struct Noise {
    int row = 0;               // first row in P
    int column = 0;            // first column in P
    std::vector<int> rows;     // of each its place in the block
    std::vector<int> columns;  // added to that; empty: a diagonal block
    int block = 0;             // index into the table of noise block pointers
  };
  /// An element of Qd on or below the diagonal: where in P, and where in which block.
  struct NoiseElement {
    int at = 0;
    int block = 0;
    int place = 0;
  };
  /// Neighbouring elements of one block.
  struct NoiseRun {
    int block = 0;
    int first = 0;
    int end = 0;
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
  std::vector<NoiseRun> noise_runs;
};

/// Fills `coupled`, `uncoupled`, `scaled_rows`, `noise_elements` and `noise_runs` from the rest.
void finish(TransitionPlan& plan);

/// Φ and Qd of the tables of block pointers, n×n.
void expand_transition(const TransitionPlan& plan, const double* const* phi, MatrixView Phi);
void expand_noise(const TransitionPlan& plan, const double* const* noise, MatrixView Qd);

/// The group's coefficients in one run of memory, from `to` on; returns its end.
template <int R>
inline double* collect_rows(const RowGroup& group, const double* const* phi, double* to) {
  for (const auto& column : group.columns) {
    const double* from = phi[column.block] + column.offset;
    for (int r = 0; r < R; ++r) to[r] = from[r];
    to += R;
  }
  return to;
}

inline double* collect(const RowGroup& group, const double* const* phi, double* to) {
  switch (group.rows) {
    case 1: return collect_rows<1>(group, phi, to);
    case 2: return collect_rows<2>(group, phi, to);
    default: return collect_rows<3>(group, phi, to);
  }
}

inline constexpr const char* not_positive = "H P H' + R is not positive definite";
/// work.S = HPHt + R.
void add_noise(const UpdateWork& work);
/// L with A = L Lᵀ, of m×m matrices whose columns are `ld` doubles apart; lower triangles are read and written. False where a
/// pivot is not finite, or not above the share `least` of its diagonal element.
bool factor_symmetric(const double* A, int m, int ld, double least, double* L);
/// |L⁻¹ e|²; y, which may be e, becomes L⁻¹ e.
double whitened_square(const double* L, const double* e, int m, int ld, double* y);
/// rᵀ S⁻¹ r by the factor, the normalized innovation squared.
double normalized_innovation_squared(const UpdateWork& work);
/// delta = K r, padded(n) doubles.
void gain_times_residual(int n, const UpdateWork& work, double* delta);
/// Zeroes the rows of K that are not corrected.
void leave_considered(const std::vector<unsigned char>& corrected, int n, const UpdateWork& work);

/// In which form a filter keeps P.
enum class CovarianceKind : unsigned char { joseph, ud, square_root };
inline constexpr const char* covariance_names[] = {"joseph", "ud", "square_root"};
/// What a form of n rows remembers [doubles].
std::size_t covariance_doubles(CovarianceKind kind, int n);

/// P of n rows. Nobody else touches its memory, which lies in the arena and is all that a form remembers: what else it keeps
/// is scratch. An update is project(), then factor(), again where rows were left out or R changed, then gain() and correct(),
/// which are of what was factored last. `columns`: of P, one per column of work.H. `corrected`: by row of P, 0 where it is
/// considered (Schmidt); empty: all are corrected.
class CovarianceForm {
 public:
  virtual ~CovarianceForm() = default;

  /// P: n×n. Returns −1, or a row at which P is not positive semidefinite, which a factor cannot be made of; then nothing
  /// has changed.
  virtual int set(ConstMatrixView P) = 0;
  /// P ← Φ P Φᵀ + Qd, by tables of block pointers. Returns −1, or a row at which Qd is not positive semidefinite.
  virtual int predict(const double* const* phi, const double* const* noise) = 0;
  /// work.G = P Hᵀ and work.HPHt = H G.
  virtual void project(const std::vector<int>& columns, const UpdateWork& work) const = 0;
  /// work.S = HPHt + R, and work.L with L Lᵀ = H P Hᵀ + R. Returns null, or why there is no such L.
  virtual const char* factor(const std::vector<int>& columns, const UpdateWork& work) = 0;
  /// work.K = P Hᵀ S⁻¹, zero in rows of considered components.
  virtual void gain(const std::vector<unsigned char>& corrected, const UpdateWork& work) const = 0;
  /// P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ.
  virtual void correct(const std::vector<unsigned char>& corrected, const UpdateWork& work) = 0;
  /// Rows that the last correct(), or a transform() after it, set to zero with their columns: their variance came out below
  /// zero by no more than rounding. Forms by factors have none.
  virtual std::span<const int> rounded() const { return {}; }
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
  /// Whether all variances are in [0, limit).
  virtual bool is_below(double limit) const = 0;
  /// P, whole and symmetric to the bit, to be read until it changes.
  virtual ConstMatrixView expand() const = 0;
};

/// Allocates all that the form works with. `most_dof`: of a block that is transformed; `memory`: covariance_doubles() of
/// them, aligned to cache lines.
std::unique_ptr<CovarianceForm> make_covariance(CovarianceKind kind, const TransitionPlan& plan, int most_dof,
                                                int max_rows, double* memory);

}  // namespace binnacle::internal::filter
