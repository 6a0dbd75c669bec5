// SPDX-License-Identifier: Apache-2.0
// What the measurements of a window say about the state at its start, weighed by what was known of it before.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/time.hpp"
#include "binnacle/view.hpp"
#include "smooth/co_states.hpp"

namespace binnacle::observe {

/// W with W Wᵀ = P, n×rank: by the eigenvectors of the correlations, so that units do not matter. What P has no variance of,
/// to rounding, has no column.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& P);

/// The share D of P = W Wᵀ, the covariance at the window's start, that samples up to now remove:
///     P given the samples = W (I − D) Wᵀ ,  D = I − (I + Wᵀ Y W)⁻¹ , Y their information (process noise included) .
/// Eigenvalues are in [0, 1). It is the whitened Λ of the smoother's co-states (smooth/co_states.hpp) at the window's start, but
/// summed forwards (a fixed-point smoother; Anderson and Moore, Optimal Filtering, 1979, 7.2), with M = Ψ W, Ψ the transition of
/// the error from the window's start through steps and updates:
///     step    M ← Φ M ,  P ← Φ P Φᵀ + Qd
///     update  D ← D + (H M)ᵀ S⁻¹ (H M) ,  M ← (I − K H) M ,  P ← (I − K H) P ,  S = H P Hᵀ + R ,  K = P Hᵀ S⁻¹ .
/// Gains are optimal, whatever the filter's were: considered components count as estimated.
class Information {
 public:
  /// P: n×n, at the window's start. measurements: how many the filter has. without_noise: as if Qd were zero.
  Information(const smooth::TransitionPattern& pattern, const Eigen::MatrixXd& P, int measurements, bool without_noise);

  /// A step with the gathered Φ.
  void step(const double* phi, ConstMatrixView Qd);
  /// A sample: H is m×n, R m×m. False where S is not positive definite; then it is left out.
  bool update(int measurement, ConstMatrixView H, ConstMatrixView R);
  /// The reset Jacobian of an update, n×n.
  void reset(ConstMatrixView T);
  /// P was opened by these variances, n, on its diagonal: noise like that of a step.
  void inflate(const double* variances);

  const Eigen::MatrixXd& root() const { return W_; }
  /// D, rank×rank.
  const Eigen::MatrixXd& removed() const { return D_; }
  /// What a measurement has added to it. They depend on the order: what two measurements show counts for the first.
  const Eigen::MatrixXd& removed_by(int measurement) const { return by_[static_cast<std::size_t>(measurement)]; }
  /// Of the error now; P where the filter's gains are optimal.
  const Eigen::MatrixXd& covariance() const { return P_; }

 private:
  /// out ← A Φᵀ.
  void times_transition(const Eigen::MatrixXd& A, const double* phi, Eigen::MatrixXd& out) const;

  const smooth::TransitionPattern& pattern_;
  bool without_noise_;
  Eigen::MatrixXd W_, P_, Mt_, D_;  // Mt: Mᵀ
  std::vector<Eigen::MatrixXd> by_;
  Eigen::MatrixXd next_Mt_, scratch_, gain_, factor_, V_, Z_;
};

/// D over time, at no more than so many times: when it is full, every other one is dropped.
class History {
 public:
  void add(Time t, const Eigen::MatrixXd& removed);
  struct Entry {
    Time t = no_time;
    Eigen::MatrixXd removed;
  };
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
  std::size_t every_ = 1, since_ = 0;
};

}  // namespace binnacle::observe
