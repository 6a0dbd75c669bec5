// SPDX-License-Identifier: Apache-2.0
// Arithmetic on P. Only the lower triangle is computed, then mirrored.
#include "filter/covariance.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"

namespace binnacle::internal::filter {

using base::as_size;

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
  std::vector<bool> is_coupled(as_size(plan.n), false);
  for (const auto& group : plan.groups)
    for (int r = 0; r < group.rows; ++r) is_coupled[as_size(group.first_row + r)] = true;
  const auto append = [](std::vector<RowRun>& runs, int row) {
    if (runs.empty() || runs.back().end() != row) {
      const int position = runs.empty() ? 0 : runs.back().position + runs.back().count;
      runs.push_back({row, 0, position});
    }
    ++runs.back().count;
  };
  for (int row = 0; row < plan.n; ++row) {
    const bool coupled = is_coupled[as_size(row)];
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

Joseph::Joseph(const TransitionPlan& plan, int most_dof, double* P)
    : plan_(plan), P_(P), ld_(padded(plan.n)), ld_coupled_(padded(plan.coupled_rows)), d_(as_size(ld_)) {
  std::size_t coefficients = 0;
  for (const auto& group : plan.groups) coefficients += group.columns.size() * as_size(group.rows);
  coefficients_.resize(coefficients);
  M_.resize(as_size(ld_) * as_size(ld_coupled_));
  Mt_.resize(M_.size());
  PAA_.resize(as_size(ld_coupled_) * as_size(ld_coupled_));
  transformed_.resize(as_size(ld_) * as_size(most_dof));
  for (int row = 0; row < plan.n; ++row) rows_.push_back(row);
}

/// M = P Φ_Aᵀ and P'_AA = Φ_A M.
void Joseph::predict_coupled(const double* const* phi) {
  const StripLoops& loops = strip_loops();
  double* out = M_.data();
  double* next = coefficients_.data();
  for (const auto& group : plan_.groups) {
    const double* own = next;
    next = collect(group, phi, next);
    loops.combine(group.rows, P_, ld_, 0, static_cast<int>(group.indices.size()), group.indices.data(), own, group.rows,
                  out);
    out = column_at(out, ld_, group.rows);
  }
  loops.transpose(M_.data(), ld_, ld_coupled_, Mt_.data(), ld_coupled_);
  out = PAA_.data();
  int position = 0;
  const double* own = coefficients_.data();
  for (const auto& group : plan_.groups) {
    loops.combine(group.rows, Mt_.data(), ld_coupled_, position / strip * strip, static_cast<int>(group.indices.size()),
                  group.indices.data(), own, group.rows, out);
    own += group.indices.size() * as_size(group.rows);
    out = column_at(out, ld_coupled_, group.rows);
    position += group.rows;
  }
}

/// The columns of A in the lower triangle: d_B M_BA, and P'_AA from PAA.
void Joseph::store_coupled() {
  const double* const __restrict d = d_.data();
  for (const auto& columns : plan_.coupled)
    for (int j = columns.first; j < columns.end(); ++j) {
      const int a = columns.position + j - columns.first;
      double* const __restrict to = column_at(P_, ld_, j);
      const double* const __restrict m = column_at(M_.data(), ld_, a);
      for (int i = j / strip * strip; i < ld_; i += strip)  // what is not of B is written over
        for (int k = 0; k < strip; ++k) to[i + k] = d[i + k] * m[i + k];
      for (const auto& rows : plan_.uncoupled) {
        if (rows.first > j) break;
        for (int i = rows.first; i < rows.end(); ++i) column_at(P_, ld_, i)[j] = d[i] * m[i];
      }
      const double* const __restrict aa = column_at(PAA_.data(), ld_coupled_, a);
      for (const auto& rows : plan_.coupled) {
        const int shift = rows.position - rows.first;
        for (int i = std::max(rows.first, j); i < rows.end(); ++i) to[i] = aa[i + shift];
      }
    }
}

/// P'_BB = d_B d_B' P_BB in the lower triangle; what else is in those columns is written over.
void Joseph::scale_uncoupled() {
  const double* const __restrict d = d_.data();
  for (const auto& columns : plan_.uncoupled)
    for (int j = columns.first; j < std::min(columns.end(), plan_.scaled_rows); ++j) {
      double* const __restrict to = column_at(P_, ld_, j);
      const double own = d[j];
      for (int i = j / strip * strip; i < ld_; i += strip)
        for (int k = 0; k < strip; ++k) to[i + k] *= d[i + k] * own;
    }
}

// With A the coupled rows (dense groups) and B the others (identity or a single diagonal element d):
//   M = P Φ_Aᵀ                      n × A
//   P'_BA = d_B M_BA                because Φ_B is diagonal
//   P'_AA = Φ_A M                   by the same strip kernel, on the transpose of M
//   P'_BB = d_B d_B' P_BB
// Only the lower triangle of P' is made; the upper is its mirror image, so P stays symmetric to the bit.
void Joseph::predict(const double* const* phi, const double* const* noise) {
  std::fill(d_.begin(), d_.end(), 1.0);
  for (const auto& diagonal : plan_.diagonals) d_[as_size(diagonal.row)] = phi[diagonal.block][diagonal.offset];
  if (plan_.coupled_rows > 0) predict_coupled(phi);
  scale_uncoupled();
  store_coupled();
  for (const auto& element : plan_.noise_elements) P_[element.at] += noise[element.block][element.place];
  strip_loops().mirror(P_, plan_.n);
}

void Joseph::project(const std::vector<int>& columns, const UpdateWork& work) const {
  const int count = static_cast<int>(columns.size());
  const int* index = columns.data();
  const auto combine = strip_loops().combine;
  for (int row = 0; row < work.m; row += 3)
    combine(std::min(3, work.m - row), P_, ld_, 0, count, index, work.H + row, work.m_max, column_at(work.G, ld_, row));
  for (int j = 0; j < work.m; ++j) {
    const double* g = column_at(work.G, ld_, j);
    for (int i = j; i < work.m; ++i) {
      double sum = 0;
      for (int c = 0; c < count; ++c) sum += column_at(work.H, work.m_max, c)[i] * g[index[c]];
      column_at(work.HPHt, work.m_max, j)[i] = column_at(work.HPHt, work.m_max, i)[j] = sum;
    }
  }
}

void Joseph::correct(const UpdateWork& work) {
  strip_loops().correct(P_, plan_.n, work);
  strip_loops().mirror(P_, plan_.n);
}

void Joseph::transform(const double* T, int first, int d) {
  double* const PTt = transformed_.data();  // P Tᵀ in the block's columns
  for (int r = 0; r < d; r += 3)
    strip_loops().combine(std::min(3, d - r), P_, ld_, 0, d, rows_.data() + first, T + r, d, column_at(PTt, ld_, r));
  // Outside the block that is P'; inside it still wants T from the left.
  for (int r = 0; r < d; ++r) {
    const double* in = column_at(PTt, ld_, r);
    std::copy_n(in, ld_, column_at(P_, ld_, first + r));
    for (int i = 0; i < first; ++i) column_at(P_, ld_, i)[first + r] = in[i];
    for (int i = first + d; i < plan_.n; ++i) column_at(P_, ld_, i)[first + r] = in[i];
  }
  for (int r = 0; r < d; ++r)
    for (int s = r; s < d; ++s) {
      double sum = 0;
      for (int c = 0; c < d; ++c) sum += column_at(T, d, c)[s] * column_at(PTt, ld_, r)[first + c];
      column_at(P_, ld_, first + r)[first + s] = column_at(P_, ld_, first + s)[first + r] = sum;
    }
}

void expand_transition(const TransitionPlan& plan, const double* const* phi, MatrixView Phi) {
  Phi.as().setIdentity();
  for (const auto& diagonal : plan.diagonals) Phi(diagonal.row, diagonal.row) = phi[diagonal.block][diagonal.offset];
  for (const auto& group : plan.groups)
    for (int row = group.first_row; row < group.first_row + group.rows; ++row) {
      Phi(row, row) = 0;
      for (const auto& [column, block, offset] : group.columns)
        Phi(row, column) = phi[block][offset + row - group.first_row];
    }
}

void expand_noise(const TransitionPlan& plan, const double* const* noise, MatrixView Qd) {
  const int ld = padded(plan.n);
  Qd.as().setZero();
  for (const auto& [at, block, place] : plan.noise_elements)
    Qd(at % ld, at / ld) = Qd(at / ld, at % ld) += noise[block][place];
}

void Joseph::scale(const double* d) {
  for (int j = 0; j < plan_.n; ++j)
    for (int i = 0; i < plan_.n; ++i) column_at(P_, ld_, j)[i] *= d[i] * d[j];
}

bool factor_innovation(const UpdateWork& work) {
  const MatrixView HPHt{work.HPHt, work.m, work.m, work.m_max}, R{work.R, work.m, work.m, work.m_max};
  const MatrixView S{work.S, work.m, work.m, work.m_max}, L{work.L, work.m, work.m, work.m_max};
  S.as() = HPHt.as() + R.as();
  for (int j = 0; j < work.m; ++j) {
    double pivot = S(j, j);
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < work.m; ++i) {
      double sum = S(i, j);
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum / L(j, j);
    }
  }
  return true;
}

double normalized_innovation_squared(const UpdateWork& work) {
  const MatrixView L{work.L, work.m, work.m, work.m_max};
  double nis = 0;
  for (int i = 0; i < work.m; ++i) {
    double sum = work.r[i];
    for (int k = 0; k < i; ++k) sum -= L(i, k) * work.y[k];
    work.y[i] = sum / L(i, i);
    nis += work.y[i] * work.y[i];
  }
  return nis;
}

void gain(const std::vector<unsigned char>& corrected, int n, const UpdateWork& work) {
  strip_loops().gain(n, work);
  if (corrected.empty()) return;
  for (int j = 0; j < work.m; ++j)
    for (int i = 0; i < n; ++i)
      if (!corrected[as_size(i)]) column_at(work.K, padded(n), j)[i] = 0;
}

void gain_times_residual(int n, const UpdateWork& work, double* __restrict delta) {
  std::fill_n(delta, padded(n), 0.0);
  for (int j = 0; j < work.m; ++j)
    for (int i = 0; i < padded(n); ++i) delta[i] += work.r[j] * column_at(work.K, padded(n), j)[i];
}

}  // namespace binnacle::internal::filter
