// SPDX-License-Identifier: Apache-2.0
// Arithmetic on P. Strips of four rows, as two pairs, are held in registers.
#include "filter/covariance.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace binnacle {
namespace {

typedef double Pair __attribute__((vector_size(2 * sizeof(double))));

// By value through memcpy: P is 16-byte aligned at best.
inline Pair load(const double* p) {
  Pair pair;
  std::memcpy(&pair, p, sizeof pair);
  return pair;
}
inline void store(double* p, Pair pair) { std::memcpy(p, &pair, sizeof pair); }
inline Pair both(double a) { return Pair{a, a}; }

/// Rows i … i+2·Pairs−1 of out(·, r) = Σ_c coefficients[r + c·stride] · in(·, columns[c]), for r < R.
template <int R, int Pairs>
inline void combine_strip(const double* in, int ld, int count, const int* columns, const double* coefficients,
                          int stride, double* out) {
  Pair sum[R][Pairs] = {};
  for (int c = 0; c < count; ++c) {
    const double* p = in + static_cast<std::ptrdiff_t>(columns[c]) * ld;
    Pair value[Pairs];
    for (int k = 0; k < Pairs; ++k) value[k] = load(p + 2 * k);
    const double* a = coefficients + static_cast<std::ptrdiff_t>(c) * stride;
    for (int r = 0; r < R; ++r) {
      const Pair factor = both(a[r]);
      for (int k = 0; k < Pairs; ++k) sum[r][k] += factor * value[k];
    }
  }
  for (int r = 0; r < R; ++r)
    for (int k = 0; k < Pairs; ++k) store(out + 2 * k + static_cast<std::ptrdiff_t>(r) * ld, sum[r][k]);
}

/// The same for rows first…ld−1, eight at a time: twelve sums of three rows just fit the sixteen registers of SSE2.
template <int R>
inline void combine_rows(const double* in, int ld, int first, int count, const int* columns, const double* coefficients,
                         int stride, double* out) {
  int i = first;
  for (; i + 8 <= ld; i += 8) combine_strip<R, 4>(in + i, ld, count, columns, coefficients, stride, out + i);
  if (i < ld) combine_strip<R, 2>(in + i, ld, count, columns, coefficients, stride, out + i);
}

inline void combine(int rows, const double* in, int ld, int first, int count, const int* columns,
                    const double* coefficients, int stride, double* out) {
  switch (rows) {
    case 1: combine_rows<1>(in, ld, first, count, columns, coefficients, stride, out); break;
    case 2: combine_rows<2>(in, ld, first, count, columns, coefficients, stride, out); break;
    default: combine_rows<3>(in, ld, first, count, columns, coefficients, stride, out); break;
  }
}

}  // namespace

void finish(TransitionPlan& plan) {
  std::vector<bool> is_coupled(static_cast<std::size_t>(plan.n), false);
  for (const auto& group : plan.groups)
    for (int r = 0; r < group.rows; ++r) is_coupled[static_cast<std::size_t>(group.first_row + r)] = true;
  for (int row = 0; row < plan.n; ++row)
    (is_coupled[static_cast<std::size_t>(row)] ? plan.coupled : plan.uncoupled).push_back(row);
  std::sort(plan.groups.begin(), plan.groups.end(),
            [](const RowGroup& a, const RowGroup& b) { return a.first_row < b.first_row; });
  for (auto& group : plan.groups)
    for (const auto& column : group.columns) group.indices.push_back(column.column);
}

std::size_t predict_scratch(const TransitionPlan& plan) {
  const auto coupled = plan.coupled.size();
  const auto ld = static_cast<std::size_t>(padded(plan.n));
  const auto ld_coupled = static_cast<std::size_t>(padded(static_cast<int>(coupled)));
  std::size_t coefficients = 0;
  for (const auto& group : plan.groups) coefficients += group.columns.size() * static_cast<std::size_t>(group.rows);
  return ld * coupled + 2 * ld_coupled * static_cast<std::size_t>(plan.n) + static_cast<std::size_t>(plan.n) +
         coefficients;
}

// With A the coupled rows (dense groups) and B the others (identity or a single diagonal element d):
//   M = P Φ_Aᵀ                      n × A
//   P'_BA = d_B M_BA                because Φ_B is diagonal
//   P'_AA = Φ_A M                   by the same strip kernel, on the transpose of M
//   P'_BB = d_B d_B' P_BB
void predict(const TransitionPlan& plan, const double* const* phi, const double* const* noise, double* P,
             double* scratch) {
  const int n = plan.n;
  const int ld = padded(n);
  const int coupled = static_cast<int>(plan.coupled.size());
  const int ld_coupled = padded(coupled);
  double* const M = scratch;                                               // ld × coupled
  double* const Mt = M + static_cast<std::ptrdiff_t>(ld) * coupled;        // ld_coupled × n
  double* const PAA = Mt + static_cast<std::ptrdiff_t>(ld_coupled) * n;    // ld_coupled × coupled
  double* const d = PAA + static_cast<std::ptrdiff_t>(ld_coupled) * n;     // n
  double* const coefficients = d + n;                                      // of all groups, one after the other

  if (coupled > 0) {
    double* out = M;
    double* next = coefficients;
    for (const auto& group : plan.groups) {
      const double* own = next;
      for (const auto& column : group.columns) {
        const double* from = phi[column.block] + column.offset;
        for (int r = 0; r < group.rows; ++r) *next++ = from[r];
      }
      combine(group.rows, P, ld, 0, static_cast<int>(group.indices.size()), group.indices.data(), own, group.rows, out);
      out += static_cast<std::ptrdiff_t>(group.rows) * ld;
    }
    for (int a = 0; a < coupled; ++a) {
      const double* column = M + static_cast<std::ptrdiff_t>(a) * ld;
      for (int i = 0; i < n; ++i) Mt[a + static_cast<std::ptrdiff_t>(i) * ld_coupled] = column[i];
    }
    for (int a = coupled; a < ld_coupled; ++a)
      for (int i = 0; i < n; ++i) Mt[a + static_cast<std::ptrdiff_t>(i) * ld_coupled] = 0;
    out = PAA;
    int position = 0;
    const double* own = coefficients;
    for (const auto& group : plan.groups) {
      // Only the lower triangle is needed: start at the strip that holds the group's first row.
      combine(group.rows, Mt, ld_coupled, position / strip * strip, static_cast<int>(group.indices.size()),
              group.indices.data(), own, group.rows, out);
      own += group.indices.size() * static_cast<std::size_t>(group.rows);
      out += static_cast<std::ptrdiff_t>(group.rows) * ld_coupled;
      position += group.rows;
    }
  }

  if (!plan.diagonals.empty()) {
    std::fill_n(d, n, 1.0);
    for (const auto& diagonal : plan.diagonals) d[diagonal.row] = phi[diagonal.block][diagonal.offset];
    for (const int j : plan.uncoupled) {
      double* column = P + static_cast<std::ptrdiff_t>(j) * ld;
      // Symmetric to the bit: (d_i d_j) is the same product both ways.
      for (int i = 0; i < n; ++i) column[i] *= d[i] * d[j];
    }
  }

  for (int a = 0; a < coupled; ++a) {
    const int row = plan.coupled[static_cast<std::size_t>(a)];
    double* column = P + static_cast<std::ptrdiff_t>(row) * ld;
    const double* m = M + static_cast<std::ptrdiff_t>(a) * ld;
    if (plan.diagonals.empty()) {
      for (const int b : plan.uncoupled) column[b] = P[row + static_cast<std::ptrdiff_t>(b) * ld] = m[b];
    } else {
      for (const int b : plan.uncoupled) column[b] = P[row + static_cast<std::ptrdiff_t>(b) * ld] = d[b] * m[b];
    }
    const double* aa = PAA + static_cast<std::ptrdiff_t>(a) * ld_coupled;
    for (int b = a; b < coupled; ++b) {
      const int other = plan.coupled[static_cast<std::size_t>(b)];
      column[other] = P[row + static_cast<std::ptrdiff_t>(other) * ld] = aa[b];
    }
  }

  for (const auto& q : plan.noise) {
    const double* block = noise[q.block];
    if (q.stride == 0) {
      for (int i = 0; i < q.rows; ++i) {
        const auto at = q.row + i + static_cast<std::ptrdiff_t>(q.column + i) * ld;
        P[at] += block[i];
        if (q.row != q.column) P[q.column + i + static_cast<std::ptrdiff_t>(q.row + i) * ld] = P[at];
      }
    } else if (q.row == q.column) {
      // A model's block is symmetric only to rounding: its lower triangle is what counts.
      for (int j = 0; j < q.columns; ++j)
        for (int i = j; i < q.rows; ++i) {
          const auto at = q.row + i + static_cast<std::ptrdiff_t>(q.column + j) * ld;
          P[at] += block[i + static_cast<std::ptrdiff_t>(j) * q.stride];
          P[q.column + j + static_cast<std::ptrdiff_t>(q.row + i) * ld] = P[at];
        }
    } else {
      for (int j = 0; j < q.columns; ++j)
        for (int i = 0; i < q.rows; ++i) {
          const auto at = q.row + i + static_cast<std::ptrdiff_t>(q.column + j) * ld;
          P[at] += block[i + static_cast<std::ptrdiff_t>(j) * q.stride];
          P[q.column + j + static_cast<std::ptrdiff_t>(q.row + i) * ld] = P[at];
        }
    }
  }
}

void project(const UpdateColumns& columns, const double* P, int n, int m, const UpdateWork& work) {
  const int ld = padded(n);
  const int count = static_cast<int>(columns.columns.size());
  const int* index = columns.columns.data();
  for (int row = 0; row < m; row += 3)
    combine(std::min(3, m - row), P, ld, 0, count, index, work.H + row, work.m_max,
            work.G + static_cast<std::ptrdiff_t>(row) * ld);
  for (int j = 0; j < m; ++j) {
    const double* g = work.G + static_cast<std::ptrdiff_t>(j) * ld;
    for (int i = j; i < m; ++i) {
      double sum = 0;
      for (int c = 0; c < count; ++c) sum += work.H[i + static_cast<std::ptrdiff_t>(c) * work.m_max] * g[index[c]];
      work.HPHt[i + static_cast<std::ptrdiff_t>(j) * work.m_max] = sum;
      work.HPHt[j + static_cast<std::ptrdiff_t>(i) * work.m_max] = sum;
    }
  }
}

bool factor_innovation(int m, const UpdateWork& work) {
  const auto at = [&](int i, int j) { return i + static_cast<std::ptrdiff_t>(j) * work.m_max; };
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < m; ++i) work.S[at(i, j)] = work.HPHt[at(i, j)] + work.R[at(i, j)];
  for (int j = 0; j < m; ++j) {
    double pivot = work.S[at(j, j)];
    for (int k = 0; k < j; ++k) pivot -= work.L[at(j, k)] * work.L[at(j, k)];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    const double diagonal = std::sqrt(pivot);
    work.L[at(j, j)] = diagonal;
    for (int i = j + 1; i < m; ++i) {
      double sum = work.S[at(i, j)];
      for (int k = 0; k < j; ++k) sum -= work.L[at(i, k)] * work.L[at(j, k)];
      work.L[at(i, j)] = sum / diagonal;
    }
  }
  return true;
}

double normalized_innovation_squared(int m, const UpdateWork& work) {
  double nis = 0;
  for (int i = 0; i < m; ++i) {
    double sum = work.r[i];
    for (int k = 0; k < i; ++k) sum -= work.L[i + static_cast<std::ptrdiff_t>(k) * work.m_max] * work.y[k];
    work.y[i] = sum / work.L[i + static_cast<std::ptrdiff_t>(i) * work.m_max];
    nis += work.y[i] * work.y[i];
  }
  return nis;
}

void correct(const unsigned char* corrected, double* P, int n, int m, const UpdateWork& work) {
  const int ld = padded(n);
  const auto column = [ld](double* matrix, int j) { return matrix + static_cast<std::ptrdiff_t>(j) * ld; };
  const auto L = [&](int i, int j) { return work.L[i + static_cast<std::ptrdiff_t>(j) * work.m_max]; };
  const auto S = [&](int i, int j) { return work.S[i + static_cast<std::ptrdiff_t>(j) * work.m_max]; };

  // K Lᵀ' : forward and back substitution on the columns of G, a column of n rows at a time.
  for (int j = 0; j < m; ++j) {
    double* k = column(work.K, j);
    std::memcpy(k, column(work.G, j), static_cast<std::size_t>(ld) * sizeof(double));
    for (int l = 0; l < j; ++l) {
      const double* kl = column(work.K, l);
      const double a = L(j, l);
      for (int i = 0; i < ld; ++i) k[i] -= a * kl[i];
    }
    const double inverse = 1 / L(j, j);
    for (int i = 0; i < ld; ++i) k[i] *= inverse;
  }
  for (int j = m - 1; j >= 0; --j) {
    double* k = column(work.K, j);
    for (int l = j + 1; l < m; ++l) {
      const double* kl = column(work.K, l);
      const double a = L(l, j);
      for (int i = 0; i < ld; ++i) k[i] -= a * kl[i];
    }
    const double inverse = 1 / L(j, j);
    for (int i = 0; i < ld; ++i) k[i] *= inverse;
  }
  if (corrected)
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < n; ++i)
        if (!corrected[i]) column(work.K, j)[i] = 0;

  // P + K Uᵀ + U Kᵀ with U = ½ K S − G.
  for (int j = 0; j < m; ++j) {
    double* u = column(work.U, j);
    const double* g = column(work.G, j);
    for (int i = 0; i < ld; ++i) u[i] = -g[i];
    for (int l = 0; l < m; ++l) {
      const double* k = column(work.K, l);
      const double half = 0.5 * S(l, j);
      for (int i = 0; i < ld; ++i) u[i] += half * k[i];
    }
  }
  // Element (i, j) and (j, i) get the same two products in the same order, so P stays symmetric to the bit (as long as
  // the compiler does not contract them: this file is compiled with -ffp-contract=off).
  for (int c = 0; c < n; ++c) {
    double* p = column(P, c);
    for (int i = 0; i < ld; i += 2) {
      Pair sum = load(p + i);
      for (int j = 0; j < m; ++j) {
        const double* k = column(work.K, j);
        const double* u = column(work.U, j);
        sum += load(k + i) * both(u[c]) + load(u + i) * both(k[c]);
      }
      store(p + i, sum);
    }
  }
}

void gain_times_residual(int n, int m, const UpdateWork& work, double* delta) {
  const int ld = padded(n);
  std::fill_n(delta, n, 0.0);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) delta[i] += work.K[i + static_cast<std::ptrdiff_t>(j) * ld] * work.r[j];
}

void transform_block(const double* T, int first, int d, double* P, int n, double* scratch) {
  const int ld = padded(n);
  for (int r = 0; r < d; ++r) {
    double* out = scratch + static_cast<std::ptrdiff_t>(r) * ld;
    std::fill_n(out, ld, 0.0);
    for (int c = 0; c < d; ++c) {
      const double a = T[r + static_cast<std::ptrdiff_t>(c) * d];
      const double* in = P + static_cast<std::ptrdiff_t>(first + c) * ld;
      for (int i = 0; i < ld; ++i) out[i] += a * in[i];
    }
  }
  // scratch = P Tᵀ in the block's columns. Outside the block that is P'; inside it still wants T from the left.
  for (int r = 0; r < d; ++r) {
    const double* in = scratch + static_cast<std::ptrdiff_t>(r) * ld;
    double* column = P + static_cast<std::ptrdiff_t>(first + r) * ld;
    for (int i = 0; i < n; ++i) {
      if (i >= first && i < first + d) continue;
      column[i] = P[first + r + static_cast<std::ptrdiff_t>(i) * ld] = in[i];
    }
  }
  for (int r = 0; r < d; ++r)
    for (int s = r; s < d; ++s) {
      double sum = 0;
      for (int c = 0; c < d; ++c)
        sum += T[s + static_cast<std::ptrdiff_t>(c) * d] * scratch[first + c + static_cast<std::ptrdiff_t>(r) * ld];
      P[first + s + static_cast<std::ptrdiff_t>(first + r) * ld] = sum;
      P[first + r + static_cast<std::ptrdiff_t>(first + s) * ld] = sum;
    }
}

}  // namespace binnacle
