// SPDX-License-Identifier: Apache-2.0
// What all forms of the covariance share: the structure of a step written out, and what follows from S and K.
#include "filter/covariance_form.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"
#include "filter/covariance.hpp"
#include "filter/factored_form.hpp"

namespace binnacle::internal::filter {

using base::as_size;

namespace {

/// Of a model's own dense block, which is symmetric only to rounding, the lower triangle is what counts.
void list_elements(const TransitionPlan::Noise& noise, int ld, std::vector<TransitionPlan::NoiseElement>& elements) {
  const auto add = [&](int i, int j, int place) {
    const int row = noise.row + i, column = noise.column + j;
    elements.push_back({std::max(row, column) + std::min(row, column) * ld, noise.block, place});
  };
  const int rows = base::count_of(noise.rows), columns = base::count_of(noise.columns);
  if (columns == 0)
    for (int i = 0; i < rows; ++i) add(i, i, noise.rows[as_size(i)]);
  for (int j = 0; j < columns; ++j)
    for (int i = noise.row == noise.column ? j : 0; i < rows; ++i)
      add(i, j, noise.rows[as_size(i)] + noise.columns[as_size(j)]);
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
  for (const auto& noise : plan.noise) {
    const int first = base::count_of(plan.noise_elements);
    list_elements(noise, padded(plan.n), plan.noise_elements);
    plan.noise_runs.push_back({noise.block, first, base::count_of(plan.noise_elements)});
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

void add_noise(const UpdateWork& work) {
  const MatrixView HPHt{work.HPHt, work.m, work.m, work.m_max}, R{work.R, work.m, work.m, work.m_max};
  MatrixView{work.S, work.m, work.m, work.m_max}.as() = HPHt.as() + R.as();
}

bool factor_symmetric(const double* A, int m, int ld, double least, double* L) {
  for (int j = 0; j < m; ++j) {
    const double diagonal = A[j + j * ld];
    double pivot = diagonal;
    for (int k = 0; k < j; ++k) pivot -= L[j + k * ld] * L[j + k * ld];
    if (!(pivot > least * diagonal) || !std::isfinite(pivot)) return false;
    L[j + j * ld] = std::sqrt(pivot);
    for (int i = j + 1; i < m; ++i) {
      double sum = A[i + j * ld];
      for (int k = 0; k < j; ++k) sum -= L[i + k * ld] * L[j + k * ld];
      L[i + j * ld] = sum / L[j + j * ld];
    }
  }
  return true;
}

double whitened_square(const double* L, const double* e, int m, int ld, double* y) {
  double square = 0;
  for (int i = 0; i < m; ++i) {
    double sum = e[i];
    for (int k = 0; k < i; ++k) sum -= L[i + k * ld] * y[k];
    y[i] = sum / L[i + i * ld];
    square += y[i] * y[i];
  }
  return square;
}

double normalized_innovation_squared(const UpdateWork& work) {
  return whitened_square(work.L, work.r, work.m, work.m_max, work.y);
}

void gain_times_residual(int n, const UpdateWork& work, double* __restrict delta) {
  std::fill_n(delta, padded(n), 0.0);
  for (int j = 0; j < work.m; ++j)
    for (int i = 0; i < padded(n); ++i) delta[i] += work.r[j] * column_at(work.K, padded(n), j)[i];
}

void leave_considered(const std::vector<unsigned char>& corrected, int n, const UpdateWork& work) {
  if (corrected.empty()) return;
  for (int j = 0; j < work.m; ++j)
    for (int i = 0; i < n; ++i)
      if (!corrected[as_size(i)]) column_at(work.K, padded(n), j)[i] = 0;
}

std::size_t covariance_doubles(CovarianceKind kind, int n) {
  const std::size_t square = as_size(padded(n)) * as_size(n);
  return kind == CovarianceKind::ud ? square + as_size(padded(n)) : square;
}

std::unique_ptr<CovarianceForm> make_covariance(CovarianceKind kind, const TransitionPlan& plan, int most_dof,
                                                int max_rows, double* memory) {
  switch (kind) {
    case CovarianceKind::ud: return std::make_unique<Ud>(plan, max_rows, memory);
    case CovarianceKind::square_root: return std::make_unique<SquareRoot>(plan, max_rows, memory);
    default: return std::make_unique<Joseph>(plan, most_dof, memory);
  }
}

}  // namespace binnacle::internal::filter
