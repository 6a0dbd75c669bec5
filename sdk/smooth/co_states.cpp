// SPDX-License-Identifier: Apache-2.0
#include "smooth/co_states.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include <Eigen/Cholesky>

#include "binnacle/eigen.hpp"
#include "wording/wording.hpp"

namespace binnacle::smooth {

using namespace wording;
using Eigen::MatrixXd;

namespace {

/// Rows of P that a block's coupling touches: pairs (to, from).
void add_coupling(const FilterInfo& filter, const Coupling& coupling, std::vector<std::set<int>>& columns) {
  const BlockInfo& to = filter.blocks[as_size(coupling.to)];
  const BlockInfo& from = filter.blocks[as_size(coupling.from)];
  for (std::size_t a = 0; a < to.active.size(); ++a)
    for (std::size_t b = 0; b < from.active.size(); ++b)
      if (coupling.structure == Structure::dense || to.active[a] == from.active[b])
        columns[as_size(from.first_row) + b].insert(to.first_row + static_cast<int>(a));
}

void symmetrize(MatrixXd& A) {
  for (Eigen::Index j = 0; j < A.cols(); ++j)
    for (Eigen::Index i = j + 1; i < A.rows(); ++i) A(i, j) = A(j, i) = 0.5 * (A(i, j) + A(j, i));
}

}  // namespace

TransitionPattern::TransitionPattern(const FilterInfo& filter) : n_(filter.dof) {
  std::vector<std::set<int>> columns(as_size(n_));
  for (int j = 0; j < n_; ++j) columns[as_size(j)].insert(j);
  for (const Coupling& coupling : filter.transition) add_coupling(filter, coupling, columns);
  if (filter.is_unscented)
    for (auto& column : columns)
      for (int i = 0; i < n_; ++i) column.insert(i);
  first_.push_back(0);
  for (const auto& column : columns) {
    rows_.insert(rows_.end(), column.begin(), column.end());
    first_.push_back(static_cast<int>(rows_.size()));
  }
}

TransitionPattern::TransitionPattern(int n) : n_(n) {
  for (int j = 0; j <= n; ++j) first_.push_back(j * n);
  for (int k = 0; k < n * n; ++k) rows_.push_back(k % n);
}

void TransitionPattern::gather(ConstMatrixView Phi, double* values) const {
  for (int j = 0; j < n_; ++j)
    for (int k = first_[as_size(j)]; k < first_[as_size(j) + 1]; ++k) *values++ = Phi(rows_[as_size(k)], j);
}

CoStates::CoStates(const TransitionPattern& pattern, std::vector<unsigned char> considered, int max_rows)
    : pattern_(pattern), considered_(std::move(considered)) {
  const int n = pattern.n();
  for (auto* vector : {&lambda_, &next_lambda_}) vector->setZero(n);
  for (auto* square : {&Lambda_, &noise_, &scratch_, &other_, &third_}) square->setZero(n, n);
  V_.resize(n, max_rows);
  tall_.resize(n, max_rows);
  other_tall_.resize(n, max_rows);
  inverse_.resize(max_rows, max_rows);
  D_.resize(max_rows, max_rows);
  factor_.resize(max_rows, max_rows);
  s_.resize(max_rows);
}

bool CoStates::clear() {
  const bool was_known = !Lambda_.isZero(0);
  lambda_.setZero();
  Lambda_.setZero();
  noise_.setZero();
  return was_known;
}

void CoStates::times_transition(const MatrixXd& A, const double* phi, MatrixXd& out) const {
  const int n = pattern_.n();
  const auto& first = pattern_.first();
  const auto& rows = pattern_.rows();
  for (int j = 0; j < n; ++j) {
    double* const to = out.col(j).data();
    const int begin = first[as_size(j)], end = first[as_size(j) + 1];
    const double* from = A.col(rows[as_size(begin)]).data();
    for (int i = 0; i < n; ++i) to[i] = phi[begin] * from[i];
    for (int k = begin + 1; k < end; ++k) {
      from = A.col(rows[as_size(k)]).data();
      for (int i = 0; i < n; ++i) to[i] += phi[k] * from[i];
    }
  }
}

void CoStates::transform(MatrixXd& A, const double* phi) {
  times_transition(A, phi, scratch_);
  other_ = scratch_.transpose();
  times_transition(other_, phi, A);
  symmetrize(A);
}

void CoStates::step(const double* phi, ConstMatrixView Qd) {
  if (has_considered()) {
    scratch_.noalias() = Lambda_ * Qd.as();
    noise_.noalias() += scratch_ * Lambda_;
    transform(noise_, phi);
  }
  transform(Lambda_, phi);
  for (int j = 0; j < pattern_.n(); ++j) {
    double sum = 0;
    for (int k = pattern_.first()[as_size(j)]; k < pattern_.first()[as_size(j) + 1]; ++k)
      sum += phi[k] * lambda_[pattern_.rows()[as_size(k)]];
    next_lambda_[j] = sum;
  }
  lambda_.swap(next_lambda_);
}

void CoStates::undo_reset(ConstMatrixView T) {
  next_lambda_.noalias() = T.as().transpose() * lambda_;
  lambda_.swap(next_lambda_);
  for (MatrixXd* A : {&Lambda_, &noise_}) {
    if (A == &noise_ && !has_considered()) break;
    scratch_.noalias() = *A * T.as();
    A->noalias() = T.as().transpose() * scratch_;
    symmetrize(*A);
  }
}

namespace {

/// Whether a factor of S in doubles says anything of S⁻¹. A filter that keeps a factor of P may have used a sample of which it does
/// not: rows that see the same, with a prior that is beyond 1e15 of their noise.
template <class Factor>
bool is_regular(const Factor& factor, ConstMatrixView S) {
  if (factor.info() != Eigen::Success) return false;
  const auto& L = factor.matrixLLT();
  for (int j = 0; j < S.rows; ++j)
    if (!(L(j, j) * L(j, j) > 8 * S.rows * std::numeric_limits<double>::epsilon() * S(j, j))) return false;
  return true;
}

}  // namespace

// With s = S⁻¹ r − Kᵀ λ, V = Λ K and W = Λ (I − K H) = Λ − V H,
//     λ ← Hᵀ S⁻¹ r + (I − K H)ᵀ λ = λ + Hᵀ s ,
//     Λ ← Hᵀ S⁻¹ H + (I − K H)ᵀ W = W + Hᵀ (S⁻¹ H − Kᵀ W) .
// One factor after the other: where P is large, I − K H is small, and Λ − V H − Hᵀ Vᵀ + … would lose it in the rounding of Λ.
void CoStates::update(const UpdateTerms& terms) {
  if (terms.reset) undo_reset(terms.reset);
  const int m = terms.S.rows;
  const auto H = terms.H.as();
  const auto K = terms.K.as();
  auto V = V_.leftCols(m);
  auto inverse = inverse_.topLeftCorner(m, m);
  auto s = s_.head(m);
  factor_.topLeftCorner(m, m) = terms.S.as();
  Eigen::Ref<MatrixXd> in_place(factor_.topLeftCorner(m, m));
  const Eigen::LLT<Eigen::Ref<MatrixXd>> S(in_place);
  if (!is_regular(S, terms.S)) {  // nothing before it can be smoothed, and no number says that it was
    lambda_.setConstant(std::numeric_limits<double>::quiet_NaN());
    Lambda_.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  s = ConstVectorView(terms.residual, m).as();
  S.solveInPlace(s);
  s.noalias() -= K.transpose() * lambda_;
  inverse.setIdentity();
  S.solveInPlace(inverse);
  V.noalias() = Lambda_ * K;
  auto D = D_.topLeftCorner(m, m);
  D = inverse;
  D.noalias() += K.transpose() * V;
  if (has_considered()) update_noise(terms);
  lambda_.noalias() += H.transpose() * s;
  Lambda_.noalias() -= V * H;
  auto gain = tall_.leftCols(m);  // transposed
  gain.noalias() = H.transpose() * inverse;
  gain.noalias() -= Lambda_.transpose() * K;
  Lambda_.noalias() += H.transpose() * gain.transpose();
  symmetrize(Lambda_);
}

// λ ← (Hᵀ S⁻¹ − (I − K H)ᵀ V) v + (I − K H)ᵀ ν with r = H e + v.
void CoStates::update_noise(const UpdateTerms& terms) {
  const int m = terms.S.rows;
  const auto H = terms.H.as();
  const auto K = terms.K.as();
  auto B = tall_.leftCols(m);
  B.noalias() = noise_ * K;
  scratch_.noalias() = B * H;
  noise_ -= scratch_;
  B.noalias() = noise_.transpose() * K;
  scratch_.noalias() = H.transpose() * B.transpose();
  noise_ -= scratch_;
  B = -V_.leftCols(m);
  B.noalias() += H.transpose() * D_.topLeftCorner(m, m);
  auto BR = other_tall_.leftCols(m);
  BR.noalias() = B * terms.R.as();
  noise_.noalias() += BR * B.transpose();
  symmetrize(noise_);
}

void CoStates::inflate(const double* variances) {
  if (!has_considered()) return;
  for (int i = 0; i < pattern_.n(); ++i)
    if (variances[i] != 0) noise_.noalias() += variances[i] * Lambda_.col(i) * Lambda_.row(i);
}

void CoStates::correction(ConstMatrixView P, double* delta) {
  Eigen::Map<Eigen::VectorXd> out(delta, pattern_.n());
  out.noalias() = P.as() * lambda_;
  for (std::size_t i = 0; i < considered_.size(); ++i)
    if (considered_[i]) delta[i] = 0;
}

void CoStates::covariance(ConstMatrixView P, MatrixView smoothed) {
  auto out = smoothed.as();
  scratch_.noalias() = P.as() * Lambda_;
  if (!has_considered()) {
    out = P.as();
    out.noalias() -= scratch_ * P.as();
  } else {
    // A = I − M P Λ; then M P N P M.
    other_ = P.as();
    for (int i = 0; i < pattern_.n(); ++i)
      if (considered_[as_size(i)]) {
        scratch_.row(i).setZero();
        other_.row(i).setZero();
      }
    scratch_ = -scratch_;
    scratch_.diagonal().array() += 1;
    third_.noalias() = scratch_ * P.as();
    out.noalias() = third_ * scratch_.transpose();
    third_.noalias() = other_ * noise_;
    out.noalias() += third_ * other_.transpose();
  }
  for (int j = 0; j < smoothed.cols; ++j)
    for (int i = j + 1; i < smoothed.rows; ++i)
      smoothed(i, j) = smoothed(j, i) = 0.5 * (smoothed(i, j) + smoothed(j, i));
}

}  // namespace binnacle::smooth
