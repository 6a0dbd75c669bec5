// SPDX-License-Identifier: Apache-2.0
// StripLoops: the inner loops of the covariance's arithmetic, once per instruction set.
#pragma once

#include <cstddef>

namespace binnacle::internal::filter {

/// Columns of P are this many doubles apart: n rounded up to whole SIMD strips. Padding rows stay zero.
inline constexpr int strip = 4;
constexpr int padded(int n) { return (n + strip - 1) / strip * strip; }

/// Column j of a matrix whose columns are ld doubles apart. Whole numbers only, so any processor runs it.
template <class Double>
constexpr Double* column_at(Double* matrix, int ld, int j) {
  return matrix + static_cast<std::ptrdiff_t>(j) * ld;
}

/// Neighbouring rows of P of one kind; `position`: of the first among all rows of that kind.
struct RowRun {
  int first = 0;
  int count = 0;
  int position = 0;
  constexpr int end() const { return first + count; }
};

/// Runs of rows, ascending.
struct RowRuns {
  const RowRun* first = nullptr;
  int count = 0;
  constexpr const RowRun* begin() const { return first; }
  constexpr const RowRun* end() const { return first + count; }
};

/// Rows of Φ that share their columns: coefficients[r + c·rows] for r < rows ≤ 3, c < count.
struct CombinedRows {
  int rows = 0;
  int count = 0;
  const int* columns = nullptr;
  const double* coefficients = nullptr;
};

/// What a prediction makes of the coupled rows A, which the groups give in order; all memory is the caller's.
struct CoupledParts {
  int ld = 0, ld_coupled = 0;  // of P and M; of Mt
  const CombinedRows* groups = nullptr;
  int count = 0;
  double* M = nullptr;   // ld × A, rounded up to whole strips
  double* Mt = nullptr;  // its transpose
  double* AA = nullptr;  // may be P
  int ld_AA = 0;
};

/// What a prediction puts together to P: A are the coupled rows, B the others.
struct PredictedParts {
  int ld = 0, ld_coupled = 0;  // of P and M; of AA
  RowRuns coupled, uncoupled;
  int scaled_rows = 0;         // behind the last of B whose diagonal element is not 1
  const double* d = nullptr;   // ld: the diagonal of Φ, 1 in rows of A
  const double* M = nullptr;   // ld × A: P Φ_Aᵀ
  const double* AA = nullptr;  // ld_coupled × A: Φ_A M; null: A are the first rows, and P has it
};

/// What an update of m rows works with; all memory is the caller's. Matrices are column-major.
struct UpdateWork {
  int m = 0;
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

/// Strips of rows are held in registers. Every set multiplies and adds the same numbers in the same order, without
/// contraction, so that results do not depend on the processor.
struct StripLoops {
  /// Rows first…ld−1 of out(·, r) = Σ_c coefficients[r + c·stride] · in(·, columns[c]) for r < rows ≤ 3, c < count.
  void (*combine)(int rows, const double* in, int ld, int first, int count, const int* columns,
                  const double* coefficients, int stride, double* out);
  /// out(j, i) = in(i, j) for ld rows and `columns` columns, both of whole strips.
  void (*transpose)(const double* in, int ld, int columns, double* out, int ld_out);
  /// M = P Φ_Aᵀ and AA = Φ_A M: of each column of AA the strips from the first of its group's rows on. P is read before AA
  /// is written.
  void (*couple)(const double* P, const CoupledParts& parts);
  /// The lower triangle of P: P_BB ← d d′ P_BB, P_BA = d M_BA and P_AA = AA.
  void (*store)(double* P, const PredictedParts& parts);
  /// P(j, i) = P(i, j) for i > j.
  void (*mirror)(double* P, int n);
  /// The columns of gain() before any is zeroed.
  void (*gain)(int n, const UpdateWork& work);
  /// The lower triangle of correct().
  void (*correct)(double* P, int n, const UpdateWork& work);
};

extern const StripLoops base_strip_loops;
/// Without functions where this program was not built for x86-64.
extern const StripLoops avx2_strip_loops;

inline bool runs_avx2() {
#if defined(__x86_64__)
  return avx2_strip_loops.combine != nullptr && __builtin_cpu_supports("avx2");
#else
  return false;
#endif
}
inline const StripLoops& strip_loops() { return runs_avx2() ? avx2_strip_loops : base_strip_loops; }

}  // namespace binnacle::internal::filter
