// SPDX-License-Identifier: Apache-2.0
// The loops of StripLoops for registers of as many doubles as the compiler may use. Included by one source file per instruction set, and all of
// it local to that file: nothing here may come out of the standard library but what the compiler itself knows, or the
// linker could hand a function made for one processor to another.
#include "filter/strip_loops.hpp"

namespace binnacle::internal::filter {
namespace {

#ifdef __AVX2__
constexpr int lanes = 4;
#else
constexpr int lanes = 2;
#endif
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));

// Scratch is 16-byte aligned at best.
typedef double LooseLanes __attribute__((vector_size(lanes * sizeof(double)), aligned(8), may_alias));
inline Lanes load(const double* p) { return *reinterpret_cast<const LooseLanes*>(p); }
inline int strip_of(int row) { return row / strip * strip; }
inline void store(double* p, Lanes value) { *reinterpret_cast<LooseLanes*>(p) = value; }

/// Rows 0 … lanes·Strips−1 of out(·, r) = Σ_c coefficients[r + c·stride] · in(·, columns[c]), for r < R.
template <int R, int Strips>
inline void combine_strip(const double* in, int ld, int count, const int* columns, const double* coefficients,
                          int stride, double* out, int ld_out) {
  Lanes sum[R][Strips];
#pragma GCC unroll 3
  for (int r = 0; r < R; ++r)
    for (int k = 0; k < Strips; ++k) sum[r][k] = Lanes{};
  for (int c = 0; c < count; ++c) {
    const double* p = column_at(in, ld, columns[c]);
    Lanes value[Strips];
    for (int k = 0; k < Strips; ++k) value[k] = load(p + lanes * k);
    const double* a = coefficients + static_cast<std::ptrdiff_t>(c) * stride;
    for (int r = 0; r < R; ++r)
      for (int k = 0; k < Strips; ++k) sum[r][k] += a[r] * value[k];
  }
#pragma GCC unroll 3
  for (int r = 0; r < R; ++r)
    for (int k = 0; k < Strips; ++k) store(column_at(out, ld_out, r) + lanes * k, sum[r][k]);
}

/// The same for rows first…end−1, three strips at a time: nine sums, three values and a factor fit sixteen registers.
template <int R>
inline void combine_rows(const double* in, int ld, int first, int end, int count, const int* columns,
                         const double* coefficients, int stride, double* out, int ld_out) {
  int i = first;
  for (; i + 3 * lanes <= end; i += 3 * lanes)
    combine_strip<R, 3>(in + i, ld, count, columns, coefficients, stride, out + i, ld_out);
  for (; i + 2 * lanes <= end; i += 2 * lanes)
    combine_strip<R, 2>(in + i, ld, count, columns, coefficients, stride, out + i, ld_out);
  for (; i < end; i += lanes) combine_strip<R, 1>(in + i, ld, count, columns, coefficients, stride, out + i, ld_out);
}

/// Of a few columns: what a call costs counts.
[[gnu::always_inline]] inline void combine_group(const CombinedRows group, int stride, const double* in, int ld,
                                                 int first, int end, double* out, int ld_out) {
  const auto& [rows, count, columns, coefficients] = group;
  switch (rows) {
    case 1: combine_rows<1>(in, ld, first, end, count, columns, coefficients, stride, out, ld_out); break;
    case 2: combine_rows<2>(in, ld, first, end, count, columns, coefficients, stride, out, ld_out); break;
    default: combine_rows<3>(in, ld, first, end, count, columns, coefficients, stride, out, ld_out); break;
  }
}

void combine(int rows, const double* in, int ld, int first, int count, const int* columns, const double* coefficients,
             int stride, double* out) {
  combine_group({rows, count, columns, coefficients}, stride, in, ld, first, ld, out, ld);
}

template <class Vector>
inline void transpose_in_registers(Vector* tile) {
  if constexpr (lanes == 2) {
    const auto a = tile[0], b = tile[1];
    tile[0] = Vector{a[0], b[0]};
    tile[1] = Vector{a[1], b[1]};
  } else {
    const auto even = [](Vector a, Vector b) { return Vector{a[0], b[0], a[2], b[2]}; };
    const auto odd = [](Vector a, Vector b) { return Vector{a[1], b[1], a[3], b[3]}; };
    const auto low = [](Vector a, Vector b) { return Vector{a[0], a[1], b[0], b[1]}; };
    const auto high = [](Vector a, Vector b) { return Vector{a[2], a[3], b[2], b[3]}; };
    const Vector left[] = {even(tile[0], tile[1]), odd(tile[0], tile[1])};
    const Vector right[] = {even(tile[2], tile[3]), odd(tile[2], tile[3])};
    for (int i = 0; i < 2; ++i) tile[i] = low(left[i], right[i]), tile[i + 2] = high(left[i], right[i]);
  }
}

/// out(j, i) = in(i, j) for i, j < lanes; only the first `columns` columns of out are there.
inline void transpose_tile(const double* in, int ld, double* out, int ld_out, int columns) {
  Lanes tile[lanes];
#pragma GCC unroll 4
  for (int j = 0; j < lanes; ++j) tile[j] = load(column_at(in, ld, j));
  transpose_in_registers(tile);
#pragma GCC unroll 4
  for (int i = 0; i < lanes; ++i)
    if (i < columns) store(column_at(out, ld_out, i), tile[i]);
}

void transpose(const double* in, int ld, int columns, double* out, int ld_out) {
  for (int j = 0; j < columns; j += lanes)
    for (int i = 0; i < ld; i += lanes)
      transpose_tile(column_at(in, ld, j) + i, ld, column_at(out, ld_out, i) + j, ld_out, lanes);
}

void couple(const double* P, const CoupledParts& given) {
  const CoupledParts parts = given;
  double* out = parts.M;
  for (int g = 0; g < parts.count; ++g) {
    combine_group(parts.groups[g], parts.groups[g].rows, P, parts.ld, 0, parts.ld, out, parts.ld);
    out = column_at(out, parts.ld, parts.groups[g].rows);
  }
  transpose(parts.M, parts.ld, parts.ld_coupled, parts.Mt, parts.ld_coupled);
  out = parts.AA;
  int position = 0;
  for (int g = 0; g < parts.count; ++g) {
    combine_group(parts.groups[g], parts.groups[g].rows, parts.Mt, parts.ld_coupled, strip_of(position),
                  parts.ld_coupled, out, parts.ld_AA);
    out = column_at(out, parts.ld_AA, parts.groups[g].rows);
    position += parts.groups[g].rows;
  }
}

/// Column j of A, the a-th: what is above j is written over. Copies of all that says where, which no store can change.
inline void store_coupled_column(double* P, const PredictedParts parts, int j, int a) {
  double* const to = column_at(P, parts.ld, j);
  const double* const m = column_at(parts.M, parts.ld, a);
  for (const RowRun rows : parts.uncoupled) {
    if (rows.first < j) {  // their columns have this row
      for (int i = rows.first; i < rows.end(); ++i) column_at(P, parts.ld, i)[j] = parts.d[i] * m[i];
      continue;
    }
    // Whole strips: what is of A in them comes last.
    for (int i = strip_of(rows.first); i < rows.end(); i += lanes) store(to + i, load(parts.d + i) * load(m + i));
  }
  const double* const aa = column_at(parts.AA, parts.ld_coupled, a);
  for (const RowRun rows : parts.coupled) {
    const double* const from = aa + rows.position - rows.first;
    int i = strip_of(j) > rows.first ? strip_of(j) : rows.first;  // as it was stored
    for (; i + lanes <= rows.end(); i += lanes) store(to + i, load(from + i));
    for (; i < rows.end(); ++i) to[i] = from[i];
  }
}

/// Columns of A, which are the first, from the first row of B on.
inline void store_below(double* P, const PredictedParts parts, int coupled) {
  const int ld = parts.ld, whole = (coupled + lanes - 1) / lanes * lanes;
  const double* const d = parts.d;
  const double* m = parts.M;
  for (int j = 0; j < coupled; ++j, P += ld, m += ld) {
    for (int i = coupled; i < whole; ++i) P[i] = d[i] * m[i];
    for (int i = whole; i < ld; i += lanes) store(P + i, load(d + i) * load(m + i));
  }
}

/// Columns of B are scaled whole, and rows of A in them come out of columns of A.
void store_predicted(double* P, const PredictedParts& given) {
  const PredictedParts parts = given;
  for (const RowRun columns : parts.uncoupled)
    for (int j = columns.first; j < columns.end() && j < parts.scaled_rows; ++j) {
      double* const to = column_at(P, parts.ld, j);
      const double own = parts.d[j];
      for (int i = strip_of(j); i < parts.ld; i += lanes) store(to + i, load(to + i) * (load(parts.d + i) * own));
    }
  if (!parts.AA) return store_below(P, parts, parts.coupled.count > 0 ? parts.coupled.first->count : 0);
  for (const RowRun columns : parts.coupled)
    for (int j = columns.first; j < columns.end(); ++j)
      store_coupled_column(P, parts, j, columns.position + j - columns.first);
}

void mirror(double* P, int n) {
  const int ld = padded(n);
  const auto at = [=](int i, int j) { return column_at(P, ld, j) + i; };
  for (int j = 0; j < n; j += lanes) {
    if (j + lanes > n) {
      for (int c = j; c < n; ++c)
        for (int r = c + 1; r < n; ++r) *at(c, r) = *at(r, c);
      return;
    }
#pragma GCC unroll 4
    for (int c = 0; c < lanes; ++c)
#pragma GCC unroll 4
      for (int r = c + 1; r < lanes; ++r) *at(j + c, j + r) = *at(j + r, j + c);
    int i = j + lanes;
    for (; i + lanes <= n; i += lanes) transpose_tile(at(i, j), ld, at(j, i), ld, lanes);
    if (i < n) transpose_tile(at(i, j), ld, at(j, i), ld, n - i);
  }
}

/// Rows i … i+lanes·Strips−1 of P(·, c+r) += Σ_j K_j u_j(c+r) + U_j k_j(c+r), for r < R.
template <int R, int Strips>
inline void add_products_strip(double* P, int ld, int i, int c, int m, const double* K, const double* U) {
  Lanes sum[R][Strips];
#pragma GCC unroll 3
  for (int r = 0; r < R; ++r)
    for (int k = 0; k < Strips; ++k) sum[r][k] = load(column_at(P, ld, c + r) + i + lanes * k);
  const auto add = [&](const double* rows, const double* factors) {
    Lanes value[Strips];
    for (int k = 0; k < Strips; ++k) value[k] = load(rows + i + lanes * k);
    for (int r = 0; r < R; ++r)
      for (int k = 0; k < Strips; ++k) sum[r][k] += factors[c + r] * value[k];
  };
  for (int j = 0; j < m; ++j) {
    add(column_at(K, ld, j), column_at(U, ld, j));
    add(column_at(U, ld, j), column_at(K, ld, j));
  }
#pragma GCC unroll 3
  for (int r = 0; r < R; ++r)
    for (int k = 0; k < Strips; ++k) store(column_at(P, ld, c + r) + i + lanes * k, sum[r][k]);
}

template <int R>
inline void add_products(double* P, int ld, int c, int m, const double* K, const double* U) {
  int i = c / strip * strip;  // only the lower triangle is needed
  for (; i + 8 <= ld; i += 8) add_products_strip<R, 8 / lanes>(P, ld, i, c, m, K, U);
  if (i < ld) add_products_strip<R, 4 / lanes>(P, ld, i, c, m, K, U);
}

/// K = G S⁻¹ by forward and back substitution on the columns of G, a column of n rows at a time.
inline void gain_columns(int n, const UpdateWork& work) {
  const int ld = padded(n), m = work.m;
  const auto L = [&](int i, int j) { return column_at(work.L, work.m_max, j)[i]; };
  const auto substitute = [&](int j, int first, int end) {
    double* k = column_at(work.K, ld, j);
    for (int l = first; l < end; ++l) {
      const double* kl = column_at(work.K, ld, l);
      const double a = l < j ? L(j, l) : L(l, j);
      for (int i = 0; i < ld; ++i) k[i] -= a * kl[i];
    }
    const double inverse = 1 / L(j, j);
    for (int i = 0; i < ld; ++i) k[i] *= inverse;
  };
  for (int j = 0; j < m; ++j) {
    __builtin_memcpy(column_at(work.K, ld, j), column_at(work.G, ld, j), static_cast<std::size_t>(ld) * sizeof(double));
    substitute(j, 0, j);
  }
  for (int j = m - 1; j >= 0; --j) substitute(j, j + 1, m);
}

/// P + K Uᵀ + U Kᵀ with U = ½ K S − G.
inline void correct_lower(double* P, int n, const UpdateWork& work) {
  const int ld = padded(n), m = work.m;
  const auto S = [&](int i, int j) { return column_at(work.S, work.m_max, j)[i]; };
  for (int j = 0; j < m; ++j) {
    double* u = column_at(work.U, ld, j);
    const double* g = column_at(work.G, ld, j);
    for (int i = 0; i < ld; ++i) u[i] = -g[i];
    for (int l = 0; l < m; ++l) {
      const double* k = column_at(work.K, ld, l);
      const double half = 0.5 * S(l, j);
      for (int i = 0; i < ld; ++i) u[i] += half * k[i];
    }
  }
  int c = 0;
  for (; c + 3 <= n; c += 3) add_products<3>(P, ld, c, m, work.K, work.U);
  for (; c < n; ++c) add_products<1>(P, ld, c, m, work.K, work.U);
}

constexpr StripLoops loops = {combine, transpose, couple, store_predicted, mirror, gain_columns, correct_lower};

}  // namespace
}  // namespace binnacle::internal::filter
