// SPDX-License-Identifier: Apache-2.0
// StripLoops: the inner loops of the covariance's arithmetic, once per instruction set.
#pragma once

#include <cstddef>

#include "filter/covariance.hpp"

namespace binnacle::filter {

/// Strips of rows are held in registers. Every set multiplies and adds the same numbers in the same order, without
/// contraction, so that results do not depend on the processor.
struct StripLoops {
  /// Rows first…ld−1 of out(·, r) = Σ_c coefficients[r + c·stride] · in(·, columns[c]) for r < rows ≤ 3, c < count.
  void (*combine)(int rows, const double* in, int ld, int first, int count, const int* columns,
                  const double* coefficients, int stride, double* out);
  /// out = Σ_c coefficients[c·stride] · in(·, c) for c < count.
  void (*combine_neighbours)(const double* in, int ld, int count, const double* coefficients, int stride, double* out);
  /// out(j, i) = in(i, j) for ld rows and `columns` columns, both of whole strips.
  void (*transpose)(const double* in, int ld, int columns, double* out, int ld_out);
  /// P(j, i) = P(i, j) for i > j.
  void (*mirror)(double* P, int n);
  /// The columns of gain() before any is zeroed.
  void (*gain)(int n, int m, const UpdateWork& work);
  /// The lower triangle of correct().
  void (*correct)(double* P, int n, int m, const UpdateWork& work);
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

}  // namespace binnacle::filter
