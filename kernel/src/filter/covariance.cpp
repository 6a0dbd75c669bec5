// SPDX-License-Identifier: Apache-2.0
// Arithmetic on P. Only the lower triangle is computed, then mirrored.
#include "filter/covariance.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "filter/strip_loops.hpp"

namespace binnacle::filter {
namespace {

typedef double Pair __attribute__((vector_size(2 * sizeof(double))));

// By value through memcpy: scratch is 16-byte aligned at best.
inline Pair load(const double* p) {
  Pair pair;
  std::memcpy(&pair, p, sizeof pair);
  return pair;
}
inline void store(double* p, Pair pair) { std::memcpy(p, &pair, sizeof pair); }

/// The group's coefficients in one run of memory; returns its end.
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

/// P(j, i) = P(i, j) for i > j, two by two.
void mirror_lower(double* P, int n, int ld) {
  const auto column = [=](int j) { return P + static_cast<std::ptrdiff_t>(j) * ld; };
  int j = 0;
  for (; j + 1 < n; j += 2) {
    double* left = column(j);
    double* right = column(j + 1);
    right[j] = left[j + 1];
    int i = j + 2;
    for (; i + 1 < n; i += 2) {
      const Pair a = load(left + i);
      const Pair b = load(right + i);
      store(column(i) + j, Pair{a[0], b[0]});
      store(column(i + 1) + j, Pair{a[1], b[1]});
    }
    if (i < n) store(column(i) + j, Pair{left[i], right[i]});
  }
}

/// out(j, i) = in(i, j) for `columns` columns of ld rows, two by two; out has ld_out rows, the rest of them zero.
void transpose(const double* in, int ld, int columns, double* out, int ld_out) {
  for (int j = 0; j < ld_out; j += 2) {
    const double* left = in + static_cast<std::ptrdiff_t>(j) * ld;
    const double* right = left + ld;
    for (int i = 0; i < ld; i += 2) {
      const Pair a = j < columns ? load(left + i) : Pair{};
      const Pair b = j + 1 < columns ? load(right + i) : Pair{};
      double* to = out + j + static_cast<std::ptrdiff_t>(i) * ld_out;
      store(to, Pair{a[0], b[0]});
      store(to + ld_out, Pair{a[1], b[1]});
    }
  }
}

}  // namespace

void finish(TransitionPlan& plan) {
  std::vector<bool> is_coupled(static_cast<std::size_t>(plan.n), false);
  for (const auto& group : plan.groups)
    for (int r = 0; r < group.rows; ++r) is_coupled[static_cast<std::size_t>(group.first_row + r)] = true;
  const auto append = [](std::vector<RowRun>& runs, int row) {
    if (runs.empty() || runs.back().end() != row) {
      const int position = runs.empty() ? 0 : runs.back().position + runs.back().count;
      runs.push_back({row, 0, position});
    }
    ++runs.back().count;
  };
  for (int row = 0; row < plan.n; ++row) {
    const bool coupled = is_coupled[static_cast<std::size_t>(row)];
    append(coupled ? plan.coupled : plan.uncoupled, row);
    plan.coupled_rows += coupled;
  }
  std::sort(plan.groups.begin(), plan.groups.end(),
            [](const RowGroup& a, const RowGroup& b) { return a.first_row < b.first_row; });
  for (auto& group : plan.groups)
    for (const auto& column : group.columns) group.indices.push_back(column.column);
}

std::size_t predict_scratch(const TransitionPlan& plan) {
  const auto coupled = static_cast<std::size_t>(plan.coupled_rows);
  const auto ld = static_cast<std::size_t>(padded(plan.n));
  const auto ld_coupled = static_cast<std::size_t>(padded(plan.coupled_rows));
  std::size_t coefficients = 0;
  for (const auto& group : plan.groups) coefficients += group.columns.size() * static_cast<std::size_t>(group.rows);
  return ld * coupled + ld_coupled * ld + ld_coupled * coupled + static_cast<std::size_t>(plan.n) + coefficients;
}

namespace {

/// The scratch of predict(): with A the coupled rows (dense groups) and B the others.
struct PredictScratch {
  PredictScratch(const TransitionPlan& plan, double* scratch)
      : ld(padded(plan.n)), ld_coupled(padded(plan.coupled_rows)), M(scratch) {
    Mt = M + static_cast<std::ptrdiff_t>(ld) * plan.coupled_rows;
    PAA = Mt + static_cast<std::ptrdiff_t>(ld_coupled) * ld;
    d = PAA + static_cast<std::ptrdiff_t>(ld_coupled) * plan.coupled_rows;
    coefficients = d + plan.n;
  }
  int ld, ld_coupled;
  double* M;             // ld × coupled: P Φ_Aᵀ
  double* Mt;            // ld_coupled × ld: Mᵀ
  double* PAA;           // ld_coupled × coupled
  double* d;             // n: diagonal of Φ
  double* coefficients;  // of all groups, one after the other
};

/// M = P Φ_Aᵀ and P'_AA = Φ_A M.
void predict_coupled(const TransitionPlan& plan, const double* const* phi, const double* P,
                     const PredictScratch& work) {
  const auto combine = strip_loops().combine;
  double* out = work.M;
  double* next = work.coefficients;
  for (const auto& group : plan.groups) {
    const double* own = next;
    next = collect(group, phi, next);
    combine(group.rows, P, work.ld, 0, static_cast<int>(group.indices.size()), group.indices.data(), own, group.rows,
            out);
    out += static_cast<std::ptrdiff_t>(group.rows) * work.ld;
  }
  transpose(work.M, work.ld, plan.coupled_rows, work.Mt, work.ld_coupled);
  out = work.PAA;
  int position = 0;
  const double* own = work.coefficients;
  for (const auto& group : plan.groups) {
    combine(group.rows, work.Mt, work.ld_coupled, position / strip * strip, static_cast<int>(group.indices.size()),
            group.indices.data(), own, group.rows, out);
    own += group.indices.size() * static_cast<std::size_t>(group.rows);
    out += static_cast<std::ptrdiff_t>(group.rows) * work.ld_coupled;
    position += group.rows;
  }
}

/// The columns of A in the lower triangle: from PAA, and d_B M_BA.
void store_coupled(const TransitionPlan& plan, bool scales, double* P, const PredictScratch& work) {
  const int ld = work.ld;
  const double* const d = work.d;
  for (const auto& columns : plan.coupled)
    for (int j = columns.first; j < columns.end(); ++j) {
      double* column = P + static_cast<std::ptrdiff_t>(j) * ld;
      const int a = columns.position + j - columns.first;
      const double* m = work.M + static_cast<std::ptrdiff_t>(a) * ld;
      for (const auto& rows : plan.uncoupled) {
        if (rows.first > j) {
          for (int i = rows.first; i < rows.end(); ++i) column[i] = scales ? d[i] * m[i] : m[i];
        } else {
          for (int i = rows.first; i < rows.end(); ++i)
            P[j + static_cast<std::ptrdiff_t>(i) * ld] = scales ? d[i] * m[i] : m[i];
        }
      }
      const double* aa = work.PAA + static_cast<std::ptrdiff_t>(a) * work.ld_coupled;
      for (const auto& rows : plan.coupled)
        for (int i = std::max(rows.first, j); i < rows.end(); ++i) column[i] = aa[rows.position + i - rows.first];
    }
}

/// Adds Qd to the lower triangle.
void add_noise(const TransitionPlan& plan, const double* const* noise, double* P, int ld) {
  for (const auto& q : plan.noise) {
    const double* block = noise[q.block];
    if (q.stride == 0) {
      const int row = std::max(q.row, q.column);
      const int column = std::min(q.row, q.column);
      for (int i = 0; i < q.rows; ++i) P[row + i + static_cast<std::ptrdiff_t>(column + i) * ld] += block[i];
    } else if (q.row < q.column) {
      for (int j = 0; j < q.columns; ++j)
        for (int i = 0; i < q.rows; ++i)
          P[q.column + j + static_cast<std::ptrdiff_t>(q.row + i) * ld] +=
              block[i + static_cast<std::ptrdiff_t>(j) * q.stride];
    } else {
      // A model's own block is symmetric only to rounding: its lower triangle is what counts.
      for (int j = 0; j < q.columns; ++j)
        for (int i = q.row == q.column ? j : 0; i < q.rows; ++i)
          P[q.row + i + static_cast<std::ptrdiff_t>(q.column + j) * ld] +=
              block[i + static_cast<std::ptrdiff_t>(j) * q.stride];
    }
  }
}

}  // namespace

// With A the coupled rows (dense groups) and B the others (identity or a single diagonal element d):
//   M = P Φ_Aᵀ                      n × A
//   P'_BA = d_B M_BA                because Φ_B is diagonal
//   P'_AA = Φ_A M                   by the same strip kernel, on the transpose of M
//   P'_BB = d_B d_B' P_BB
// Only the lower triangle of P' is made; the upper is its mirror image, so P stays symmetric to the bit.
void predict(const TransitionPlan& plan, const double* const* phi, const double* const* noise, double* P,
             double* scratch) {
  const int ld = padded(plan.n);
  const bool scales = !plan.diagonals.empty();
  const PredictScratch work(plan, scratch);
  double* const d = work.d;
  if (scales) {
    std::fill_n(d, plan.n, 1.0);
    for (const auto& diagonal : plan.diagonals) d[diagonal.row] = phi[diagonal.block][diagonal.offset];
  }
  if (plan.coupled_rows > 0) predict_coupled(plan, phi, P, work);
  if (scales)
    for (const auto& columns : plan.uncoupled)
      for (int j = columns.first; j < columns.end(); ++j) {
        double* column = P + static_cast<std::ptrdiff_t>(j) * ld;
        for (const auto& rows : plan.uncoupled)
          for (int i = std::max(rows.first, j); i < rows.end(); ++i) column[i] *= d[i] * d[j];
      }
  store_coupled(plan, scales, P, work);
  add_noise(plan, noise, P, ld);
  mirror_lower(P, plan.n, ld);
}

void expand_transition(const TransitionPlan& plan, const double* const* phi, double* Phi) {
  const auto n = static_cast<std::ptrdiff_t>(plan.n);
  std::fill_n(Phi, n * n, 0.0);
  for (std::ptrdiff_t i = 0; i < n; ++i) Phi[i + i * n] = 1;
  for (const auto& diagonal : plan.diagonals)
    Phi[diagonal.row + diagonal.row * n] = phi[diagonal.block][diagonal.offset];
  for (const auto& group : plan.groups)
    for (int r = 0; r < group.rows; ++r) {
      Phi[(group.first_row + r) * (n + 1)] = 0;
      for (const auto& column : group.columns)
        Phi[group.first_row + r + column.column * n] = phi[column.block][column.offset + r];
    }
}

void expand_noise(const TransitionPlan& plan, const double* const* noise, double* Qd) {
  const auto n = static_cast<std::ptrdiff_t>(plan.n);
  std::fill_n(Qd, n * n, 0.0);
  add_noise(plan, noise, Qd, plan.n);
  for (std::ptrdiff_t j = 0; j < n; ++j)
    for (std::ptrdiff_t i = j + 1; i < n; ++i) Qd[j + i * n] = Qd[i + j * n];
}

void project(const UpdateColumns& columns, const double* P, int n, int m, const UpdateWork& work) {
  const int ld = padded(n);
  const int count = static_cast<int>(columns.columns.size());
  const int* index = columns.columns.data();
  const auto combine = strip_loops().combine;
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

void gain(const unsigned char* corrected, int n, int m, const UpdateWork& work) {
  strip_loops().gain(n, m, work);
  if (!corrected) return;
  const int ld = padded(n);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i)
      if (!corrected[i]) work.K[i + static_cast<std::ptrdiff_t>(j) * ld] = 0;
}

void correct(double* P, int n, int m, const UpdateWork& work) {
  strip_loops().correct(P, n, m, work);
  mirror_lower(P, n, padded(n));
}

void gain_times_residual(int n, int m, const UpdateWork& work, double* delta) {
  const int ld = padded(n);
  std::fill_n(delta, n, 0.0);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) delta[i] += work.K[i + static_cast<std::ptrdiff_t>(j) * ld] * work.r[j];
}

void transform_block(const double* T, int first, int d, double* P, int n, double* scratch) {
  const int ld = padded(n);
  const auto column = [=](int j) { return P + static_cast<std::ptrdiff_t>(j) * ld; };
  const auto scratch_column = [=](int j) { return scratch + static_cast<std::ptrdiff_t>(j) * ld; };
  for (int r = 0; r < d; ++r) {
    double* out = scratch_column(r);
    std::fill_n(out, ld, 0.0);
    for (int c = 0; c < d; ++c) {
      const double a = T[r + static_cast<std::ptrdiff_t>(c) * d];
      const double* in = column(first + c);
      for (int i = 0; i < ld; ++i) out[i] += a * in[i];
    }
  }
  // scratch = P Tᵀ in the block's columns. Outside the block that is P'; inside it still wants T from the left.
  for (int r = 0; r < d; ++r) {
    const double* in = scratch_column(r);
    std::copy(in, in + first, column(first + r));
    std::copy(in + first + d, in + n, column(first + r) + first + d);
    for (int i = 0; i < first; ++i) column(i)[first + r] = in[i];
    for (int i = first + d; i < n; ++i) column(i)[first + r] = in[i];
  }
  for (int r = 0; r < d; ++r)
    for (int s = r; s < d; ++s) {
      double sum = 0;
      for (int c = 0; c < d; ++c) sum += T[s + static_cast<std::ptrdiff_t>(c) * d] * scratch_column(r)[first + c];
      column(first + r)[first + s] = sum;
      column(first + s)[first + r] = sum;
    }
}

}  // namespace binnacle::filter
