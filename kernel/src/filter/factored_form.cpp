// SPDX-License-Identifier: Apache-2.0
#include "filter/factored_form.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/index.hpp"

namespace binnacle::internal::filter {

using base::as_size;

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// A = L D Lᵀ of a positive semidefinite A, m×m, of which the lower triangle is read; L, unit lower, takes its place. A pivot that
/// is zero but for rounding is zero, and so is its column. A is refused where it is indefinite by a part of 1e-9, more than
/// rounding makes of it, and by more than `slack(i)` [as A(i, i)], which it is uncertain by besides. Returns −1, or the row
/// at which A is not positive semidefinite.
template <class Slack>
int factor_semidefinite(double* A, int m, double* d, Slack&& slack) {
  constexpr double most = 1e-9;
  const auto at = [&](int i, int j) -> double& { return column_at(A, m, j)[i]; };
  for (int j = 0; j < m; ++j) {
    const double own = std::abs(at(j, j));
    double pivot = at(j, j);
    for (int k = 0; k < j; ++k) pivot -= at(j, k) * at(j, k) * d[k];
    if (!std::isfinite(pivot) || pivot < -most * own - slack(j) || at(j, j) < -slack(j)) return j;
    const bool is_zero = pivot <= 8 * m * epsilon * own;
    d[j] = is_zero ? 0.0 : pivot;
    at(j, j) = 1;
    for (int i = j + 1; i < m; ++i) {
      double sum = at(i, j);
      for (int k = 0; k < j; ++k) sum -= at(i, k) * at(j, k) * d[k];
      // |A_ij|² ≤ A_ii A_jj, with what both are uncertain by.
      if (is_zero && sum != 0 && !(sum * sum <= (most * own + slack(j)) * (std::abs(at(i, i)) + slack(i)))) return j;
      at(i, j) = is_zero ? 0.0 : sum / pivot;
    }
  }
  return -1;
}

constexpr auto no_slack = [](int) { return 0.0; };

}  // namespace

FactoredForm::FactoredForm(const TransitionPlan& plan, CovarianceKind kind, int max_rows, double* memory)
    : n_(plan.n), ld_(padded(plan.n)), memory_(memory), plan_(plan), doubles_(covariance_doubles(kind, plan.n)) {
  group_noise();
  std::size_t noisy = 0, coefficients = 0;
  for (const auto& group : noise_groups_) noisy += group.rows.size();
  for (const auto& group : plan.groups)
    coefficients = std::max(coefficients, group.columns.size() * as_size(group.rows));
  const std::size_t ld = as_size(ld_), n = as_size(n_), rows = as_size(max_rows);
  const std::size_t most = std::max(ld, n + std::max({noisy, rows, std::size_t{1}}));
  columns_.resize(ld * most);
  weights_.resize(most);
  active_.resize(most);
  noise_variances_.resize(n);
  rows_.resize(ld * ld);
  products_.resize(ld * 3);
  coefficients_.resize(coefficients);
  updated_.resize(doubles_);
  gains_.resize(ld * rows);
  for (auto* list : {&alpha_, &variances_}) list->resize(rows);
  for (auto* square : {&M_, &R_}) square->resize(rows * rows);
  whitened_.resize(rows * n);
  f_.resize(ld);
  P_.resize(ld * n);
  made_of_.resize(doubles_, std::numeric_limits<double>::quiet_NaN());
  sums_.resize(ld);
}

/// Rows that Qd couples are factored together.
void FactoredForm::group_noise() {
  const auto row_of = [&](const TransitionPlan::NoiseElement& element) { return element.at % ld_; };
  const auto column_of = [&](const TransitionPlan::NoiseElement& element) { return element.at / ld_; };
  std::vector<int> group(as_size(n_), -1);  // of each row, by its least row
  for (const auto& element : plan_.noise_elements)
    for (const int row : {row_of(element), column_of(element)}) group[as_size(row)] = row;
  for (const auto& element : plan_.noise_elements) {
    const int a = group[as_size(row_of(element))], b = group[as_size(column_of(element))];
    std::ranges::replace(group, std::max(a, b), std::min(a, b));
  }
  std::vector<int> position(as_size(n_)), index(as_size(n_));
  std::size_t size = 0;
  for (int least = 0; least < n_; ++least) {
    NoiseGroup its;
    for (int row = least; row < n_; ++row) {
      if (group[as_size(row)] != least) continue;
      position[as_size(row)] = base::count_of(its.rows);
      index[as_size(row)] = base::count_of(noise_groups_);
      its.rows.push_back(row);
    }
    if (its.rows.empty()) continue;
    its.first = size;
    size += its.rows.size() * its.rows.size();
    noise_groups_.push_back(its);
  }
  noise_.resize(size);
  for (const auto& element : plan_.noise_elements) {
    const auto& its = noise_groups_[as_size(index[as_size(row_of(element))])];
    noise_places_.push_back(its.first + as_size(position[as_size(row_of(element))]) +
                            as_size(position[as_size(column_of(element))]) * its.rows.size());
  }
}

// ---- columns, and of many n

/// One more column, of zeros.
double* FactoredForm::add(double weight) {
  weights_[as_size(count_)] = weight;
  double* const added = column(count_++);
  std::fill_n(added, ld_, 0.0);
  return added;
}

void FactoredForm::load() {
  std::copy_n(memory_, ld_ * n_, columns_.data());
  const double* const w = weights(memory_);
  for (int k = 0; k < n_; ++k) weights_[as_size(k)] = weight_of(w, k);
  count_ = n_;
}

/// From the last row to the first: the heaviest column of those that are left takes what the others have in it.
void FactoredForm::triangularize() {
  int left = 0;
  for (int k = 0; k < count_; ++k)
    if (weights_[as_size(k)] != 0) active_[as_size(left++)] = k;
  for (int j = n_ - 1; j >= 0; --j) {
    int heaviest = -1;
    double largest = 0, sum = 0;
    for (int a = 0; a < left; ++a) {
      const int k = active_[as_size(a)];
      const double b = column(k)[j], square = weights_[as_size(k)] * b * b;
      sum += square;
      if (square > largest) {
        largest = square;
        heaviest = a;
      }
    }
    if (!std::isfinite(sum)) {  // the health check names what it is
      std::fill_n(memory_, doubles_, std::numeric_limits<double>::quiet_NaN());
      return;
    }
    if (largest < std::numeric_limits<double>::min()) {  // no variance is left
      std::fill_n(sums_.begin(), j, 0.0);
      put(j, sums_.data(), 0.0);
      continue;
    }
    const int pivot = active_[as_size(heaviest)];
    active_[as_size(heaviest)] = active_[as_size(--left)];
    eliminate(j, pivot, {active_.data(), as_size(left)});
  }
}

int FactoredForm::set(ConstMatrixView P) {
  // P = C W Cᵀ from the last row up is L D Lᵀ from the first row down, with rows and columns in reverse.
  const auto from_behind = [&](int i) { return n_ - 1 - i; };
  double* const A = rows_.data();
  for (int j = 0; j < n_; ++j)
    for (int i = j; i < n_; ++i) column_at(A, n_, j)[i] = P(from_behind(i), from_behind(j));
  if (const int row = factor_semidefinite(A, n_, weights_.data(), no_slack); row >= 0) return from_behind(row);
  for (int j = 0; j < n_; ++j) {
    for (int i = 0; i < j; ++i) f_[as_size(i)] = column_at(A, n_, from_behind(j))[from_behind(i)];
    put(j, f_.data(), weights_[as_size(from_behind(j))]);
  }
  return -1;
}

// ---- a step

/// Factors Qd and makes columns of it, beside those of C.
int FactoredForm::add_noise_columns(const double* const* noise) {
  std::fill(noise_.begin(), noise_.end(), 0.0);
  for (std::size_t e = 0; e < noise_places_.size(); ++e) {
    const auto& element = plan_.noise_elements[e];
    noise_[noise_places_[e]] += noise[element.block][element.place];
  }
  for (const auto& group : noise_groups_) {
    const int m = base::count_of(group.rows);
    double* const A = noise_.data() + group.first;
    constexpr double rounding = 1e-12;  // of the component's own variance, as for what a process may give
    const auto slack = [&](int i) { return rounding * variance(group.rows[as_size(i)]); };
    const int row = factor_semidefinite(A, m, noise_variances_.data(), slack);
    if (row >= 0) return group.rows[as_size(row)];
    for (int k = 0; k < m; ++k) {
      if (noise_variances_[as_size(k)] == 0) continue;
      double* const added = add(noise_variances_[as_size(k)]);
      for (int i = k; i < m; ++i) added[group.rows[as_size(i)]] = column_at(A, m, k)[i];
    }
  }
  return -1;
}

/// The columns of C become those of Φ C, row by row of Φ.
void FactoredForm::propagate_columns(const double* const* phi) {
  const StripLoops& loops = strip_loops();
  const auto scatter = [&](const double* from, int row) {
    for (int k = 0; k < n_; ++k) column(k)[row] = from[k];
  };
  if (!plan_.groups.empty()) loops.transpose(columns_.data(), ld_, ld_, rows_.data(), ld_);
  for (const auto& diagonal : plan_.diagonals) {
    const double d = phi[diagonal.block][diagonal.offset];
    for (int k = diagonal.row; k < n_; ++k) column(k)[diagonal.row] *= d;
  }
  for (const auto& group : plan_.groups) {
    collect(group, phi, coefficients_.data());
    loops.combine(group.rows, rows_.data(), ld_, 0, base::count_of(group.indices), group.indices.data(),
                  coefficients_.data(), group.rows, products_.data());
    for (int r = 0; r < group.rows; ++r) scatter(column_at(products_.data(), ld_, r), group.first_row + r);
  }
}

int FactoredForm::predict(const double* const* phi, const double* const* noise) {
  load();
  if (const int row = add_noise_columns(noise); row >= 0) return row;
  propagate_columns(phi);
  triangularize();
  return -1;
}

// ---- an update

/// f = Cᵀ h, of the row h of a compact H whose columns are `stride` doubles apart.
void FactoredForm::project_factor(const double* memory, const double* h, int stride, const std::vector<int>& columns,
                                  double* f) const {
  std::fill_n(f, n_, 0.0);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const double factor = h[c * as_size(stride)];
    if (factor == 0) continue;
    for (int k = columns[c]; k < n_; ++k) f[k] += factor * column_at(memory, ld_, k)[columns[c]];
  }
}

void FactoredForm::project(const std::vector<int>& columns, const UpdateWork& work) const {
  const double* const w = weights(memory_);
  double* const f = sums_.data();
  for (int j = 0; j < work.m; ++j) {
    project_factor(memory_, work.H + j, work.m_max, columns, f);
    double* const __restrict g = column_at(work.G, ld_, j);
    std::fill_n(g, ld_, 0.0);
    for (int k = 0; k < n_; ++k) {
      const double factor = weight_of(w, k) * f[k];
      const double* const c = column_at(memory_, ld_, k);
      for (int i = 0; i <= k; ++i) g[i] += factor * c[i];
    }
    for (int i = j; i < work.m; ++i) {
      double sum = 0;
      for (std::size_t c = 0; c < columns.size(); ++c)
        sum += work.H[as_size(i) + c * as_size(work.m_max)] * g[columns[c]];
      if (i == j) {  // of squares, which do not cancel
        sum = 0;
        for (int k = 0; k < n_; ++k) sum += weight_of(w, k) * f[k] * f[k];
      }
      column_at(work.HPHt, work.m_max, j)[i] = column_at(work.HPHt, work.m_max, i)[j] = sum;
    }
  }
}

/// H ← L⁻¹ H with R = L D Lᵀ in R_ and variances_.
void FactoredForm::whiten(int columns, const UpdateWork& work) {
  const int m = work.m;
  for (int c = 0; c < columns; ++c) {
    double* const h = column_at(whitened_.data(), m, c);
    std::copy_n(column_at(work.H, work.m_max, c), m, h);
    for (int i = 1; i < m; ++i)
      for (int l = 0; l < i; ++l) h[i] -= column_at(R_.data(), m, l)[i] * h[l];
  }
}

// With R = L_R D L_Rᵀ the rows of L_R⁻¹ H are independent and make an update one by one, each with a gain k_i and the variance
// α_i of its innovation. What row i leaves in a later row j is C_ji = h_j k_i: r = L_R C r′, with r′ the innovations one by one.
// So H P Hᵀ + R = M diag(α) Mᵀ with M = L_R C, unit lower, and K M = (k_1 … k_m). Neither S nor its inverse is used.
const char* FactoredForm::factor(const std::vector<int>& columns, const UpdateWork& work) {
  add_noise(work);
  const int m = work.m;
  for (int j = 0; j < m; ++j)
    for (int i = j; i < m; ++i) column_at(R_.data(), m, j)[i] = column_at(work.R, work.m_max, j)[i];
  if (factor_semidefinite(R_.data(), m, variances_.data(), no_slack) >= 0) return "R is not positive semidefinite";
  whiten(base::count_of(columns), work);
  std::copy_n(memory_, doubles_, updated_.data());
  for (int i = 0; i < m; ++i) {
    double* const k = column_at(gains_.data(), ld_, i);
    project_factor(updated_.data(), whitened_.data() + i, m, columns, f_.data());
    const double alpha = alpha_[as_size(i)] = update(updated_.data(), f_.data(), variances_[as_size(i)], k);
    if (!(alpha > 0) || !std::isfinite(alpha)) return not_positive;
    for (int row = 0; row < n_; ++row) k[row] /= alpha;
  }
  const auto C = [&](int j, int i) {
    double sum = 0;
    for (std::size_t c = 0; c < columns.size(); ++c)
      sum += whitened_[as_size(j) + c * as_size(m)] * column_at(gains_.data(), ld_, i)[columns[c]];
    return sum;
  };
  for (int i = 0; i < m; ++i) {
    double* const column = column_at(M_.data(), m, i);  // C's first, from the last row up M's
    column[i] = 1;
    for (int j = i + 1; j < m; ++j) column[j] = C(j, i);
    for (int j = m - 1; j > i; --j)
      for (int l = i; l < j; ++l) column[j] += column_at(R_.data(), m, l)[j] * column[l];
    for (int j = i; j < m; ++j) column_at(work.L, work.m_max, i)[j] = column[j] * std::sqrt(alpha_[as_size(i)]);
  }
  return nullptr;
}

void FactoredForm::gain(const std::vector<unsigned char>& corrected, const UpdateWork& work) const {
  for (int j = work.m - 1; j >= 0; --j) {
    double* const __restrict k = column_at(work.K, ld_, j);
    std::copy_n(column_at(gains_.data(), ld_, j), ld_, k);
    for (int i = j + 1; i < work.m; ++i) {
      const double factor = column_at(M_.data(), work.m, j)[i];
      const double* const other = column_at(work.K, ld_, i);
      for (int row = 0; row < n_; ++row) k[row] -= factor * other[row];
    }
  }
  leave_considered(corrected, n_, work);
}

// The optimal gain loses least, so with any other, K + ΔK, P is larger by ΔK S ΔKᵀ; and K S^½ = (√α_1 k_1 …). Considered
// components are where ΔK = −K.
void FactoredForm::correct(const std::vector<unsigned char>& corrected, const UpdateWork& work) {
  std::copy_n(updated_.data(), doubles_, memory_);
  if (corrected.empty()) return;
  load();
  for (int i = 0; i < work.m; ++i) {
    double* const added = add(alpha_[as_size(i)]);
    for (int row = 0; row < n_; ++row)
      if (!corrected[as_size(row)]) added[row] = column_at(gains_.data(), ld_, i)[row];
  }
  triangularize();
}

// ---- what else changes P

void FactoredForm::transform(const double* T, int first, int d) {
  load();
  for (int k = first; k < n_; ++k) {
    double* const to = column(k) + first;
    const double* const from = column_at(memory_, ld_, k) + first;
    std::fill_n(to, d, 0.0);
    for (int c = 0; c < d; ++c)
      for (int r = 0; r < d; ++r) to[r] += column_at(T, d, c)[r] * from[c];
  }
  triangularize();
}

void FactoredForm::inflate(int row, double variance) {
  if (variance == 0) return;
  load();
  add(variance)[row] = 1;
  triangularize();
}

void FactoredForm::scale(const double* d) {
  load();
  for (int k = 0; k < n_; ++k)
    for (int i = 0; i <= k; ++i) column(k)[i] *= d[i];
  triangularize();
}

// ---- what is seen of P

double FactoredForm::variance(int row) const {
  const double* const w = weights(memory_);
  double sum = 0;
  for (int k = row; k < n_; ++k) {
    const double c = column_at(memory_, ld_, k)[row];
    sum += weight_of(w, k) * c * c;
  }
  return sum;
}

void FactoredForm::variances(const std::vector<int>& rows, double* into) const {
  for (const int row : rows) *into++ = variance(row);
}

bool FactoredForm::is_below(double limit) const {
  const double* const w = weights(memory_);
  double* const __restrict sums = sums_.data();
  std::fill_n(sums, n_, 0.0);
  for (int k = 0; k < n_; ++k) {
    const double* const c = column_at(memory_, ld_, k);
    for (int i = 0; i <= k; ++i) sums[i] += weight_of(w, k) * c[i] * c[i];
  }
  return std::all_of(sums, sums + n_, [&](double variance) { return variance >= 0 && variance < limit; });
}

/// Made anew only of a factor that is not the one before, to the bit: whoever writes the arena need not say so.
ConstMatrixView FactoredForm::expand() const {
  const ConstMatrixView P{P_.data(), n_, n_, ld_};
  if (doubles_ == 0 || std::memcmp(memory_, made_of_.data(), doubles_ * sizeof(double)) == 0) return P;
  std::copy_n(memory_, doubles_, made_of_.data());
  const double* const w = weights(memory_);
  std::fill(P_.begin(), P_.end(), 0.0);
  for (int k = 0; k < n_; ++k) {
    const double* const c = column_at(memory_, ld_, k);
    for (int j = 0; j <= k; ++j) {
      const double factor = weight_of(w, k) * c[j];
      double* const __restrict to = column_at(P_.data(), ld_, j);
      for (int i = 0; i <= j; ++i) to[i] += factor * c[i];
    }
  }
  for (int j = 0; j < n_; ++j)
    for (int i = 0; i < j; ++i) column_at(P_.data(), ld_, i)[j] = column_at(P_.data(), ld_, j)[i];
  return P;
}

}  // namespace binnacle::internal::filter
