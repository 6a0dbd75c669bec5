// SPDX-License-Identifier: Apache-2.0
// The co-states of a filter: what later data say about the error of an earlier estimate.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/composition.hpp"
#include "binnacle/view.hpp"

namespace binnacle::smooth {

/// Where Φ of a filter may differ from the identity.
class TransitionPattern {
 public:
  explicit TransitionPattern(const FilterInfo& filter);
  /// All of it.
  explicit TransitionPattern(int n);
  int n() const { return n_; }
  /// Doubles that gather() writes.
  std::size_t size() const { return rows_.size(); }
  void gather(ConstMatrixView Phi, double* values) const;
  /// Column j of Φ: entries first_[j] … first_[j + 1] − 1 of its rows and values, the diagonal among them.
  const std::vector<int>& first() const { return first_; }
  const std::vector<int>& rows() const { return rows_; }

 private:
  int n_ = 0;
  std::vector<int> first_, rows_;
};

/// A measurement update as the filter made it: P⁺ = T ((I − K H) P (I − K H)ᵀ + K R Kᵀ) Tᵀ.
struct UpdateTerms {
  ConstMatrixView H, K, S, R;  // m×n, n×m, m×m, m×m
  const double* residual = nullptr;
  ConstMatrixView reset;  // T, n×n; null: the identity
};

/// λ and Λ of the modified Bryson–Frazier smoother (Bierman, Fixed interval smoothing with discrete measurements,
/// International Journal of Control 18, 1973), sweeping backwards. With the filter's x and P at the same place of the step log
///     x_s = x ⊞ P λ ,  P_s = P − P Λ P .
/// No inverse of P is formed, so P may be singular. What the filter feeds back needs nothing special: r is taken there.
///
/// Where gains are not optimal (considered components) λ is still linear in the error e of the estimate and later noise,
/// λ = Λ e + ν, with N = cov ν carried along; considered components stay as the filter has them, and with M the others
///     x_s = x ⊞ M P λ ,  P_s = (I − M P Λ) P (I − M P Λ)ᵀ + M P N P M .
/// N = Λ − Λ P Λ where gains are optimal, which gives the form above.
class CoStates {
 public:
  /// considered: per row of P; empty: none.
  CoStates(const TransitionPattern& pattern, std::vector<unsigned char> considered, int max_rows);

  /// Nothing later is known. False where nothing was.
  bool clear();
  /// To before a step with the gathered Φ. Qd: n×n, read only where something is considered.
  void step(const double* phi, ConstMatrixView Qd);
  /// To before an update.
  void update(const UpdateTerms& terms);
  /// To before P ← P + diag(variances).
  void inflate(const double* variances);

  bool has_considered() const { return !considered_.empty(); }
  /// δ of x_s = x ⊞ δ; needs P of the same place.
  void correction(ConstMatrixView P, double* delta);
  /// P_s, which may not be P itself.
  void covariance(ConstMatrixView P, MatrixView smoothed);

  /// s = S⁻¹ r − Kᵀ λ and D = S⁻¹ + Kᵀ Λ K of the last update, of m rows, with the co-states behind it.
  auto s(int m) const { return s_.head(m); }
  auto D(int m) const { return D_.topLeftCorner(m, m); }

  const Eigen::VectorXd& lambda() const { return lambda_; }
  const Eigen::MatrixXd& Lambda() const { return Lambda_; }

 private:
  /// out ← A Φ.
  void times_transition(const Eigen::MatrixXd& A, const double* phi, Eigen::MatrixXd& out) const;
  /// A ← Φᵀ A Φ, A symmetric.
  void transform(Eigen::MatrixXd& A, const double* phi);
  void update_noise(const UpdateTerms& terms);
  void undo_reset(ConstMatrixView T);

  const TransitionPattern& pattern_;
  std::vector<unsigned char> considered_;
  Eigen::VectorXd lambda_, next_lambda_;
  Eigen::MatrixXd Lambda_, noise_;  // Λ, N
  Eigen::MatrixXd scratch_, other_, third_;
  Eigen::MatrixXd V_, inverse_, D_, tall_, other_tall_, factor_;  // Λ K, S⁻¹
  Eigen::VectorXd s_;
};

}  // namespace binnacle::smooth
