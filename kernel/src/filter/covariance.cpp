// SPDX-License-Identifier: Apache-2.0
// Arithmetic on P. Only the lower triangle is computed, then mirrored.
#include "filter/covariance.hpp"

#include <algorithm>
#include <cmath>

#include "filter/strip_loops.hpp"

namespace binnacle::filter {

namespace {

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

/// Of a model's own dense block, which is symmetric only to rounding, the lower triangle is what counts.
void list_elements(const TransitionPlan::Noise& noise, int ld, std::vector<TransitionPlan::NoiseElement>& elements) {
  const bool is_diagonal = noise.stride == 0;
  for (int j = 0; j < (is_diagonal ? noise.rows : noise.columns); ++j)
    for (int i = is_diagonal ? j : 0; i < (is_diagonal ? j + 1 : noise.rows); ++i) {
      if (noise.row == noise.column && i < j) continue;
      const int row = noise.row + i, column = noise.column + j;
      elements.push_back({std::max(row, column) + std::min(row, column) * ld, noise.block, i + j * noise.stride});
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
  for (const auto& diagonal : plan.diagonals) plan.scaled_rows = std::max(plan.scaled_rows, diagonal.row + 1);
  for (const auto& noise : plan.noise) list_elements(noise, padded(plan.n), plan.noise_elements);
}

std::size_t predict_scratch(const TransitionPlan& plan) {
  const auto ld = static_cast<std::size_t>(padded(plan.n));
  const auto ld_coupled = static_cast<std::size_t>(padded(plan.coupled_rows));
  std::size_t coefficients = 0;
  for (const auto& group : plan.groups) coefficients += group.columns.size() * static_cast<std::size_t>(group.rows);
  return ld * ld_coupled + ld_coupled * ld + ld_coupled * ld_coupled + ld + coefficients;
}

namespace {

/// The scratch of predict(): with A the coupled rows (dense groups) and B the others. Columns of M behind the coupled ones
/// go into rows of Mt that nobody reads.
struct PredictScratch {
  PredictScratch(const TransitionPlan& plan, double* scratch)
      : ld(padded(plan.n)), ld_coupled(padded(plan.coupled_rows)), M(scratch) {
    Mt = M + static_cast<std::ptrdiff_t>(ld) * ld_coupled;
    PAA = Mt + static_cast<std::ptrdiff_t>(ld_coupled) * ld;
    d = PAA + static_cast<std::ptrdiff_t>(ld_coupled) * ld_coupled;
    coefficients = d + ld;
  }
  int ld, ld_coupled;
  double* M;             // ld × coupled: P Φ_Aᵀ
  double* Mt;            // ld_coupled × ld: Mᵀ
  double* PAA;           // ld_coupled × coupled
  double* d;             // ld: diagonal of Φ, 1 for coupled rows
  double* coefficients;  // of all groups, one after the other
};

/// M = P Φ_Aᵀ and P'_AA = Φ_A M.
void predict_coupled(const TransitionPlan& plan, const double* const* phi, const double* P,
                     const PredictScratch& work) {
  const StripLoops& loops = strip_loops();
  double* out = work.M;
  double* next = work.coefficients;
  for (const auto& group : plan.groups) {
    const double* own = next;
    next = collect(group, phi, next);
    loops.combine(group.rows, P, work.ld, 0, static_cast<int>(group.indices.size()), group.indices.data(), own,
                  group.rows, out);
    out += static_cast<std::ptrdiff_t>(group.rows) * work.ld;
  }
  loops.transpose(work.M, work.ld, work.ld_coupled, work.Mt, work.ld_coupled);
  out = work.PAA;
  int position = 0;
  const double* own = work.coefficients;
  for (const auto& group : plan.groups) {
    loops.combine(group.rows, work.Mt, work.ld_coupled, position / strip * strip,
                  static_cast<int>(group.indices.size()), group.indices.data(), own, group.rows, out);
    own += group.indices.size() * static_cast<std::size_t>(group.rows);
    out += static_cast<std::ptrdiff_t>(group.rows) * work.ld_coupled;
    position += group.rows;
  }
}

/// The columns of A in the lower triangle: d_B M_BA, and P'_AA from PAA.
void store_coupled(const TransitionPlan& plan, double* P, const PredictScratch& work) {
  const int ld = work.ld;
  const double* const __restrict d = work.d;
  for (const auto& columns : plan.coupled)
    for (int j = columns.first; j < columns.end(); ++j) {
      const int a = columns.position + j - columns.first;
      double* const __restrict column = P + static_cast<std::ptrdiff_t>(j) * ld;
      const double* const __restrict m = work.M + static_cast<std::ptrdiff_t>(a) * ld;
      for (int i = j / strip * strip; i < ld; i += strip)  // what is not of B is written over
        for (int k = 0; k < strip; ++k) column[i + k] = d[i + k] * m[i + k];
      for (const auto& rows : plan.uncoupled) {
        if (rows.first > j) break;
        for (int i = rows.first; i < rows.end(); ++i) P[j + static_cast<std::ptrdiff_t>(i) * ld] = d[i] * m[i];
      }
      const double* const __restrict aa = work.PAA + static_cast<std::ptrdiff_t>(a) * work.ld_coupled;
      for (const auto& rows : plan.coupled) {
        const int shift = rows.position - rows.first;
        for (int i = std::max(rows.first, j); i < rows.end(); ++i) column[i] = aa[i + shift];
      }
    }
}

/// P'_BB = d_B d_B' P_BB in the lower triangle; what else is in those columns is written over.
void scale_uncoupled(const TransitionPlan& plan, double* P, const PredictScratch& work) {
  const double* const __restrict d = work.d;
  for (const auto& columns : plan.uncoupled)
    for (int j = columns.first; j < std::min(columns.end(), plan.scaled_rows); ++j) {
      double* const __restrict column = P + static_cast<std::ptrdiff_t>(j) * work.ld;
      const double own = d[j];
      for (int i = j / strip * strip; i < work.ld; i += strip)
        for (int k = 0; k < strip; ++k) column[i + k] *= d[i + k] * own;
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
  const PredictScratch work(plan, scratch);
  std::fill_n(work.d, work.ld, 1.0);
  for (const auto& diagonal : plan.diagonals) work.d[diagonal.row] = phi[diagonal.block][diagonal.offset];
  if (plan.coupled_rows > 0) predict_coupled(plan, phi, P, work);
  scale_uncoupled(plan, P, work);
  store_coupled(plan, P, work);
  for (const auto& element : plan.noise_elements) P[element.at] += noise[element.block][element.place];
  strip_loops().mirror(P, plan.n);
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
  const int n = plan.n, ld = padded(n);
  std::fill_n(Qd, n * n, 0.0);
  for (const auto& element : plan.noise_elements) {
    const int row = element.at % ld, column = element.at / ld;
    Qd[row + column * n] = Qd[column + row * n] += noise[element.block][element.place];
  }
}

void project(const std::vector<int>& columns, const double* P, int n, int m, const UpdateWork& work) {
  const int ld = padded(n);
  const int count = static_cast<int>(columns.size());
  const int* index = columns.data();
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
  strip_loops().mirror(P, n);
}

void gain_times_residual(int n, int m, const UpdateWork& work, double* delta) {
  strip_loops().combine_neighbours(work.K, padded(n), m, work.r, 1, delta);
}

void transform_block(const double* T, int first, int d, double* P, int n, double* scratch) {
  const int ld = padded(n), end = first + d;
  const auto column = [=](double* matrix, int j) { return matrix + static_cast<std::ptrdiff_t>(j) * ld; };
  const auto combine = strip_loops().combine_neighbours;
  for (int r = 0; r < d; ++r) combine(column(P, first), ld, d, T + r, d, column(scratch, r));
  // scratch = P Tᵀ in the block's columns. Outside the block that is P'; inside it still wants T from the left.
  for (int r = 0; r < d; ++r) {
    const double* in = column(scratch, r);
    double* out = column(P, first + r);
    for (int i = 0; i < ld; ++i) out[i] = in[i];
    for (int i = 0; i < first; ++i) column(P, i)[first + r] = in[i];
    for (int i = end; i < n; ++i) column(P, i)[first + r] = in[i];
  }
  for (int r = 0; r < d; ++r)
    for (int s = r; s < d; ++s) {
      double sum = 0;
      for (int c = 0; c < d; ++c) sum += T[s + static_cast<std::ptrdiff_t>(c) * d] * column(scratch, r)[first + c];
      column(P, first + r)[first + s] = sum;
      column(P, first + s)[first + r] = sum;
    }
}

}  // namespace binnacle::filter
