// SPDX-License-Identifier: Apache-2.0
// Recovery from a lock-out: P is opened along what the refused rows see, as far as their residual asks for.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Factors A in place; `use` is called with the factor. False where A is not positive definite.
template <class Matrix, class Use>
bool factor_in_place(Matrix&& A, Use&& use) {
  Eigen::Ref<Eigen::MatrixXd> in_place(A);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(in_place);
  if (factor.info() != Eigen::Success) return false;
  use(factor);
  return true;
}

}  // namespace

Opening::Opening(int n, int max_rows)
    : scales(as_size(padded(n))),
      direction_(as_size(padded(n))),
      matrix_(max_rows, max_rows),
      inverse_(max_rows, max_rows),
      weights_(max_rows),
      s_(max_rows),
      z_(max_rows),
      part_z_(max_rows),
      members_(as_size(max_rows)) {}

// Let U be the refused rows and r̃ the residual with those of all other rows put to zero. Of all errors of the state that
// explain r̃, that is r_U while the other rows stay as they are,
//     g = P Hᵀ (H P Hᵀ + ε R)⁻¹ r̃ ,  s = (H g)_U ,
// is the likeliest under P: it moves what the refused rows see, and through P's correlations what goes with it unseen. What
// no error of the state explains (a residual that contradicts itself) is left out thanks to the small part of R. With
// z = S⁻¹ r and M = (S⁻¹)_UU, Baarda's statistic T = z_Uᵀ M⁻¹ z_U of the refused rows becomes, with P + c g gᵀ (Sherman,
// Morrison, 1950; H g is zero in the other rows),
//     T(c) = T − c a² / (1 + c b) ,  a = sᵀ z_U, b = sᵀ M s ,
// and c is chosen so that it is |U|, what right rows would have. Where no c does, g itself is one sigma: c = 1.
// P + c g gᵀ itself would take the errors of all components to be in the proportion of g, and the next update would be
// sure of what it made of them. So only the variances are those of P + c g gᵀ, and the correlations stay: P ← D P D.
bool Opening::find(const SampleRows& rows, const MeasurementPlan& measurement, const CovarianceForm& P,
                   const std::vector<unsigned char>& corrected, int n, const unsigned char* marked) {
  const int m = rows.m, count = collect(rows, measurement, marked);
  const auto HPHt = ConstMatrixView(rows.square(rows.HPHt)).as();
  const auto R = ConstMatrixView(rows.square(rows.R)).as();
  // A small part of R, and of HPHᵀ where the state is known far better than it is measured.
  const double epsilon = 1e-4 * std::min(1.0, HPHt.trace() / R.trace());
  auto A = matrix_.topLeftCorner(m, m);
  auto weights = weights_.head(m);
  weights.setZero();
  for (int k = 0; k < count; ++k) weights[member(k)] = rows.r[member(k)];
  A = HPHt + epsilon * R;
  if (!factor_in_place(A, [&](const auto& factor) { factor.solveInPlace(weights); })) return false;

  // g, without what is never corrected, and s.
  Eigen::Map<Eigen::VectorXd> g(direction_.data(), n);
  g.noalias() = ConstMatrixView{rows.G, n, m, padded(n)}.as().lazyProduct(weights);
  for (std::size_t i = 0; i < corrected.size(); ++i)
    if (!corrected[i]) direction_[i] = 0;
  for (int k = 0; k < count; ++k) {
    s_[k] = 0;
    for (std::size_t c = 0; c < measurement.columns.size(); ++c)
      s_[k] += rows.H[as_size(member(k)) + c * as_size(rows.m_max)] * direction_[as_size(measurement.columns[c])];
  }

  if (!is_explained(rows, epsilon)) return false;

  auto inverse = inverse_.topLeftCorner(m, m);
  auto z = z_.head(m);
  inverse.setIdentity();
  z = ConstVectorView(rows.r, m).as();
  A = HPHt + R;
  const auto invert = [&](const auto& factor) {
    factor.solveInPlace(inverse);
    factor.solveInPlace(z);
  };
  if (!factor_in_place(A, invert)) return false;
  auto M = matrix_.topLeftCorner(count, count);
  auto part_z = part_z_.head(count);
  for (int j = 0; j < count; ++j) {
    part_z[j] = z[member(j)];
    for (int i = 0; i < count; ++i) M(i, j) = inverse(member(i), member(j));
  }
  const auto s = s_.head(count);
  const double a = s.dot(part_z), b = s.dot(M.lazyProduct(s));
  if (!factor_in_place(M, [&](const auto& factor) { factor.matrixL().solveInPlace(part_z); })) return false;
  const double excess = part_z.squaredNorm() - count;
  if (!(excess > 0 && a > 0 && b > 0)) return false;
  const double c = a * a > excess * b ? excess / (a * a - excess * b) : 1.0;
  for (int i = 0; i < n; ++i) {
    const double variance = P.variance(i);
    scales[as_size(i)] = variance > 0 ? std::sqrt(1 + c * g[i] * g[i] / variance) : 1.0;
  }
  return true;
}

/// r̃ − H g = ε R w is what no error of the state explains while the other rows hold: five ranges hold fast what a sixth
/// contradicts. Where it is well beyond R, there is nothing to open.
bool Opening::is_explained(const SampleRows& rows, double epsilon) const {
  const auto R = ConstMatrixView(rows.square(rows.R)).as();
  double left = 0;
  for (int i = 0; i < rows.m; ++i)
    for (int j = 0; j < rows.m; ++j) left += R(i, j) * weights_[i] * weights_[j];
  constexpr double well_beyond = 3;
  return epsilon * epsilon * left <= well_beyond * well_beyond * rows.m;
}

/// Lists U: the marked rows; without a mask those beyond the limit of a single row, or all where there is none.
int Opening::collect(const SampleRows& rows, const MeasurementPlan& measurement, const unsigned char* marked) {
  int count = 0;
  const auto S = rows.square(rows.S);
  const auto is_meant = [&](int i) {
    return marked ? marked[i] != 0 : rows.r[i] * rows.r[i] > measurement.gate_limit[1] * S(i, i);
  };
  for (int i = 0; i < rows.m; ++i)
    if (is_meant(i)) members_[as_size(count++)] = i;
  for (int i = 0; count == 0 && i < rows.m; ++i) members_[as_size(i)] = i;
  return count > 0 ? count : rows.m;
}

// The linearization was that of an estimate which was wrong by δ: of a rotation by 45 deg it is off by a tenth.
void Estimator::keep_open() {
  constexpr double share = 0.1;
  for (int i = 0; i < plan_.n; ++i) {
    const double variance = P_->variance(i), left = share * rows_.delta[as_size(i)];
    opening_.scales[as_size(i)] = variance > 0 ? std::sqrt(1 + left * left / variance) : 1.0;
  }
  P_->scale(opening_.scales.data());
}

// Two groups agree: a receiver's position and its velocity. But no error that grew is a thousand times its sigma.
double Estimator::unconfirmed(bool is_confirmed) const {
  constexpr double far = 5;
  const auto S = rows_.square(rows_.S);
  int group = -1;
  double farthest = 0;
  for (int i = 0; i < rows_.m; ++i) {
    const double z = std::abs(rows_.r[i]) / std::sqrt(S(i, i));
    if (z > Tally::beyond_reason) return z;
    if (z <= far) continue;
    farthest = std::max(farthest, z);
    is_confirmed |= group >= 0 && group != rows_.groups[as_size(i)];
    group = rows_.groups[as_size(i)];
  }
  return is_confirmed ? 0 : farthest;
}

void Estimator::project(const MeasurementPlan& measurement) { P_->project(measurement.columns, rows_); }

// The mean residual of n samples has the noise R / n, and what of P is common to all of them.
bool Estimator::open_by_mean(const MeasurementPlan& measurement) {
  const MatrixView R = rows_.square(rows_.R);
  const ConstMatrixView S = rows_.square(rows_.innovation_S);
  if (rows_.judged_R != rows_.R) R.as() = rows_.square(rows_.judged_R).as();
  for (int i = 0; i < rows_.m; ++i) {
    rows_.r[i] = rows_.mean_z[as_size(i)] * std::sqrt(S(i, i));
    for (int j = 0; j < rows_.m; ++j) R(i, j) /= std::sqrt(rows_.mean_count[as_size(i)] * rows_.mean_count[as_size(j)]);
  }
  return open(measurement, rows_.biased.data());
}

// x' = φ x + w with |φ| < 1 has the variance q / (1 − φ²) when nothing is known of it.
void Estimator::note_stationary_variances() {
  double* const kept = plan_.stationary_variances.in(arena_);
  std::fill_n(kept, plan_.n, infinity);
  const auto& transition = plan_.of_models();
  for (const auto& diagonal : transition.diagonals) {
    const double phi = phi_[as_size(diagonal.block)][diagonal.offset];
    const auto noise = std::ranges::find(transition.noise_elements, diagonal.row * padded(plan_.n) + diagonal.row,
                                         [](const auto& element) { return element.at; });
    if (phi > 0 && phi < 1 && noise != transition.noise_elements.end())
      kept[diagonal.row] = noise_[as_size(noise->block)][noise->place] / (1 - phi * phi);
  }
}

double Estimator::stationary_variance(int row) const {
  const double kept = plan_.stationary_variances.in(arena_)[row];
  return std::isnan(kept) ? infinity : kept;
}

bool Estimator::open(const MeasurementPlan& measurement, const unsigned char* marked) {
  if (!opening_.find(rows_, measurement, *P_, plan_.corrected, plan_.n, marked)) return false;
  for (int i = 0; i < plan_.n; ++i) {
    const double now = P_->variance(i), most = stationary_variance(i);
    double& scale = opening_.scales[as_size(i)];
    if (scale > 1) scale = std::min(scale, std::sqrt(std::max(1.0, most / now)));
  }
  P_->scale(opening_.scales.data());
  return true;
}

// A state that was wrong made wrong values of what it met: 1-sigma of the start, in addition.
void Estimator::unlearn(double* added) {
  const double* const initial = plan_.initial_variances.in(arena_);
  for (int i = 0; i < plan_.n; ++i) {
    added[i] = 0;
    if (!plan_.corrected.empty() && !plan_.corrected[as_size(i)]) continue;
    added[i] = std::clamp(stationary_variance(i) - P_->variance(i), 0.0, initial[i]);
    P_->inflate(i, added[i]);
  }
}

}  // namespace binnacle::internal::filter
