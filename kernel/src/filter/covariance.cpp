// SPDX-License-Identifier: Apache-2.0
// Arithmetic on P. Only the lower triangle is computed, then mirrored.
#include "filter/covariance.hpp"

#include "base/index.hpp"

namespace binnacle::internal::filter {

using base::as_size;

Joseph::Joseph(const TransitionPlan& plan, int most_dof, double* P)
    : plan_(plan), P_(P), ld_(padded(plan.n)), ld_coupled_(padded(plan.coupled_rows)), d_(as_size(ld_), 1.0) {
  std::size_t coefficients = 0;
  for (const auto& group : plan.groups) coefficients += group.columns.size() * as_size(group.rows);
  coefficients_.resize(coefficients);
  for (const auto& group : plan.groups)
    groups_.push_back({group.rows, base::count_of(group.indices), group.indices.data(), nullptr});
  M_.resize(as_size(ld_) * as_size(ld_coupled_));
  Mt_.resize(M_.size());
  is_coupled_first_ = plan.coupled.size() == 1 && plan.coupled.front().first == 0;
  if (!is_coupled_first_) PAA_.resize(as_size(ld_coupled_) * as_size(ld_coupled_));
  transformed_.resize(as_size(ld_) * as_size(most_dof));
  for (int row = 0; row < plan.n; ++row) rows_.push_back(row);
  before_.resize(as_size(most_dof));
  rounded_.reserve(2 * as_size(plan.n));
}

/// M = P Φ_Aᵀ and P'_AA = Φ_A M.
void Joseph::predict_coupled(const double* const* phi) {
  double* next = coefficients_.data();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const RowGroup& group = plan_.groups[g];
    groups_[g].coefficients =
        group.is_in_one_run ? phi[group.columns.front().block] + group.columns.front().offset : next;
    if (!group.is_in_one_run) next = collect(group, phi, next);
  }
  double* const AA = is_coupled_first_ ? P_ : PAA_.data();
  strip_loops().couple(P_, {ld_, ld_coupled_, groups_.data(), base::count_of(groups_), M_.data(), Mt_.data(), AA,
                            is_coupled_first_ ? ld_ : ld_coupled_});
}

// With A the coupled rows (dense groups) and B the others (identity or a single diagonal element d):
//   M = P Φ_Aᵀ                      n × A
//   P'_BA = d_B M_BA                because Φ_B is diagonal
//   P'_AA = Φ_A M                   by the same strip kernel, on the transpose of M
//   P'_BB = d_B d_B' P_BB
// Only the lower triangle of P' is made; the upper is its mirror image, so P stays symmetric to the bit.
int Joseph::predict(const double* const* phi, const double* const* noise) {
  for (const auto& diagonal : plan_.diagonals) d_[as_size(diagonal.row)] = phi[diagonal.block][diagonal.offset];
  if (plan_.coupled_rows > 0) predict_coupled(phi);
  const auto runs = [](const std::vector<RowRun>& of) { return RowRuns{of.data(), base::count_of(of)}; };
  strip_loops().store(P_, {ld_, ld_coupled_, runs(plan_.coupled), runs(plan_.uncoupled), plan_.scaled_rows, d_.data(),
                           M_.data(), is_coupled_first_ ? nullptr : PAA_.data()});
  double* const P = P_;
  const TransitionPlan::NoiseElement* const elements = plan_.noise_elements.data();
  for (const auto& run : plan_.noise_runs) {
    const double* const block = noise[run.block];
    for (const auto *element = elements + run.first, *const end = elements + run.end; element != end; ++element)
      P[element->at] += block[element->place];
  }
  strip_loops().mirror(P_, plan_.n);
  return -1;
}

/// With negative zeros.
bool Joseph::is_below_but_for_zeros(double limit) const {
  for (int row = 0; row < plan_.n; ++row)
    if (!(variance(row) >= 0 && variance(row) < limit)) return false;
  return true;
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

const char* Joseph::factor(const std::vector<int>&, const UpdateWork& work) {
  add_noise(work);
  return factor_symmetric(work.S, work.m, work.m_max, 0, work.L) ? nullptr : not_positive;
}

void Joseph::gain(const std::vector<unsigned char>& corrected, const UpdateWork& work) const {
  strip_loops().gain(plan_.n, work);
  leave_considered(corrected, plan_.n, work);
}

// What is left of a variance that an update takes away is the difference of two large numbers. A component that it makes known
// to fewer than twelve digits of what it was is one that is known: with a variance of zero, and correlated with nothing.
template <class Before>
void Joseph::settle_variances(int first, int end, const Before& before) {
  std::uint64_t signs = 0;
  const double* diagonal = column_at(P_, ld_, first) + first;
  const std::ptrdiff_t next = ld_ + 1;
  for (const double* const behind = diagonal + (end - first) * next; diagonal != behind; diagonal += next)
    signs |= std::bit_cast<std::uint64_t>(*diagonal);
  if (signs >> 63 == 0) return;
  constexpr double rounding = 1e-12;
  for (int row = first; row < end; ++row) {
    const double variance = column_at(P_, ld_, row)[row];
    if (!(variance < 0) || variance < -rounding * before(row)) continue;
    for (int i = 0; i < plan_.n; ++i) column_at(P_, ld_, row)[i] = column_at(P_, ld_, i)[row] = 0;
    if (rounded_.size() < rounded_.capacity()) rounded_.push_back(row);
  }
}

// Holds for any K: rows of considered components are zero in it.
void Joseph::correct(const std::vector<unsigned char>&, const UpdateWork& work) {
  rounded_.clear();
  strip_loops().correct(P_, plan_.n, work);
  strip_loops().mirror(P_, plan_.n);
  settle_variances(0, plan_.n, [&](int row) {  // P + K Uᵀ + U Kᵀ is what it is now
    double variance = column_at(P_, ld_, row)[row];
    for (int j = 0; j < work.m; ++j) variance -= 2 * column_at(work.K, ld_, j)[row] * column_at(work.U, ld_, j)[row];
    return variance;
  });
}

void Joseph::transform(const double* T, int first, int d) {
  for (int i = 0; i < d; ++i) before_[as_size(i)] = column_at(P_, ld_, first + i)[first + i];
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
  settle_variances(first, first + d, [&](int row) { return before_[as_size(row - first)]; });
}

void Joseph::scale(const double* d) {
  for (int j = 0; j < plan_.n; ++j)
    for (int i = 0; i < plan_.n; ++i) column_at(P_, ld_, j)[i] *= d[i] * d[j];
}

}  // namespace binnacle::internal::filter
