// SPDX-License-Identifier: Apache-2.0
#include "observe/information.hpp"

#include <limits>

#include "algebra/decompositions.hpp"
#include "binnacle/eigen.hpp"

namespace binnacle::observe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void symmetrize(MatrixXd& A) {
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = j + 1; i < A.rows(); ++i) A(i, j) = A(j, i) = 0.5 * (A(i, j) + A(j, i));
}

}  // namespace

MatrixXd square_root(const MatrixXd& P) {
  const Index n = P.rows();
  const VectorXd sigma = P.diagonal().cwiseMax(0).cwiseSqrt();
  MatrixXd C = MatrixXd::Zero(n, n);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i)
      if (sigma[i] > 0 && sigma[j] > 0) C(i, j) = P(i, j) / (sigma[i] * sigma[j]);
  const algebra::Spectrum spectrum = algebra::spectrum(C);
  const double least = static_cast<double>(n) * std::numeric_limits<double>::epsilon() * spectrum.values.maxCoeff();
  const Index dropped = (spectrum.values.array() <= least).count();
  return sigma.asDiagonal() * spectrum.vectors.rightCols(n - dropped) *
         spectrum.values.tail(n - dropped).cwiseSqrt().asDiagonal();
}

Information::Information(const smooth::TransitionPattern& pattern, const MatrixXd& P, int measurements,
                         bool without_noise)
    : pattern_(pattern), without_noise_(without_noise), W_(square_root(P)), P_(P), Mt_(W_.transpose()) {
  D_.setZero(W_.cols(), W_.cols());
  by_.assign(static_cast<std::size_t>(measurements), D_);
}

void Information::times_transition(const MatrixXd& A, const double* phi, MatrixXd& out) const {
  out.setZero(A.rows(), A.cols());
  const auto& first = pattern_.first();
  const auto& rows = pattern_.rows();
  for (Index j = 0; j < A.cols(); ++j)
    for (auto k = static_cast<std::size_t>(first[static_cast<std::size_t>(j)]);
         k < static_cast<std::size_t>(first[static_cast<std::size_t>(j) + 1]); ++k)
      if (phi[k] != 0) out.col(rows[k]) += phi[k] * A.col(j);
}

void Information::step(const double* phi, ConstMatrixView Qd) {
  times_transition(Mt_, phi, next_Mt_);
  Mt_.swap(next_Mt_);
  times_transition(P_, phi, scratch_);
  scratch_.transposeInPlace();
  times_transition(scratch_, phi, P_);
  if (!without_noise_) P_ += Qd.as();
  symmetrize(P_);
}

// With S = L Lᵀ, V = L⁻¹ H P and Z = L⁻¹ H M:  K H M = Vᵀ Z ,  K H P = Vᵀ V.
bool Information::update(int measurement, ConstMatrixView H, ConstMatrixView R) {
  V_.noalias() = H.as() * P_;
  factor_.noalias() = V_ * H.as().transpose();
  factor_ += R.as();
  const algebra::Cholesky S(factor_);
  if (!S.is_positive()) return false;
  Z_.noalias() = H.as() * Mt_.transpose();
  V_ = S.solve_L(V_);
  Z_ = S.solve_L(Z_);
  gain_.noalias() = Z_.transpose() * Z_;
  D_ += gain_;
  by_[static_cast<std::size_t>(measurement)] += gain_;
  Mt_.noalias() -= Z_.transpose() * V_;
  P_.noalias() -= V_.transpose() * V_;
  symmetrize(P_);
  return true;
}

void Information::reset(ConstMatrixView T) {
  next_Mt_.noalias() = Mt_ * T.as().transpose();
  Mt_.swap(next_Mt_);
  scratch_.noalias() = T.as() * P_;
  P_.noalias() = scratch_ * T.as().transpose();
  symmetrize(P_);
}

void Information::inflate(const double* variances) {
  if (without_noise_) return;
  for (Index i = 0; i < P_.rows(); ++i) P_(i, i) += variances[i];
}

void History::add(Time t, const MatrixXd& removed) {
  constexpr std::size_t most = 512;
  if (!entries_.empty() && entries_.back().t == t) {
    entries_.back().removed = removed;
    return;
  }
  if (++since_ < every_) return;
  since_ = 0;
  if (entries_.size() == most) {
    for (std::size_t i = 0; i < most / 2; ++i) entries_[i] = std::move(entries_[2 * i + 1]);
    entries_.resize(most / 2);
    every_ *= 2;
  }
  entries_.push_back({t, removed});
}

}  // namespace binnacle::observe
