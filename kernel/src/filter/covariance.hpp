// SPDX-License-Identifier: Apache-2.0
// The arithmetic of Joseph's form on a full symmetric matrix. Every function here
// keeps P exactly symmetric, allocates nothing and does no arithmetic on what the declared sparsity says is zero.
#pragma once

#include <cstddef>
#include <vector>

namespace binnacle::filter {

/// Columns of P are this many doubles apart: n rounded up to whole SIMD strips. Padding rows stay zero.
inline constexpr int strip = 4;
constexpr int padded(int n) { return (n + strip - 1) / strip * strip; }

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

/// Doubles of scratch memory that predict() needs.
std::size_t predict_scratch(const TransitionPlan& plan);

/// P ← Φ P Φᵀ + Qd. P: padded(n)×n column-major. phi, noise: tables of block pointers.
void predict(const TransitionPlan& plan, const double* const* phi, const double* const* noise, double* P,
             double* scratch);

/// Φ and Qd of the tables, n×n column-major.
void expand_transition(const TransitionPlan& plan, const double* const* phi, double* Phi);
void expand_noise(const TransitionPlan& plan, const double* const* noise, double* Qd);

/// What an update works with; all memory is the caller's. m ≤ m_max, matrices column-major.
struct UpdateWork {
  int m_max = 0;
  double* H = nullptr;     // m_max × k, compact: only the columns of touched blocks
  double* R = nullptr;     // m_max × m_max
  double* r = nullptr;     // m_max
  double* G = nullptr;     // padded(n) × m_max: P Hᵀ
  double* HPHt = nullptr;  // m_max × m_max
  double* S = nullptr;     // m_max × m_max: H P Hᵀ + R, then untouched
  double* L = nullptr;     // m_max × m_max: its Cholesky factor
  double* K = nullptr;     // padded(n) × m_max
  double* U = nullptr;     // padded(n) × m_max
  double* y = nullptr;     // m_max: L⁻¹ r
};

/// G = P Hᵀ and HPHt = H G. `columns`: of P, one per column of the compact H.
void project(const std::vector<int>& columns, const double* P, int n, int m, const UpdateWork& work);
/// S = HPHt + R and its factor; false when S is not positive definite.
bool factor_innovation(int m, const UpdateWork& work);
/// rᵀ S⁻¹ r, the normalized innovation squared.
double normalized_innovation_squared(int m, const UpdateWork& work);
/// K = G S⁻¹, with rows of K zeroed where `corrected[row]` is 0 (Schmidt); `corrected` null: none.
void gain(const unsigned char* corrected, int n, int m, const UpdateWork& work);
/// P ← (I−KH) P (I−KH)ᵀ + K R Kᵀ = P − K Gᵀ − G Kᵀ + K S Kᵀ, for any K.
void correct(double* P, int n, int m, const UpdateWork& work);
/// delta = K r, padded(n) doubles.
void gain_times_residual(int n, int m, const UpdateWork& work, double* delta);

/// P ← T P Tᵀ where T is the identity but for a d×d block (column-major) at row `first`. scratch: padded(n)·d doubles.
void transform_block(const double* T, int first, int d, double* P, int n, double* scratch);

}  // namespace binnacle::filter
