// SPDX-License-Identifier: Apache-2.0
// A run of a filter, linearized and frozen: its likelihood and the gradient of it for any noise.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "binnacle/noise_estimator.hpp"
#include "binnacle/view.hpp"

namespace binnacle::tune {

/// What is symmetric and sparse: the lower triangle's entries that are not zero.
struct SparseTerm {
  std::vector<int> at;  // row + n × column
  std::vector<double> value;
};

/// A filter's run as a linear filter about the path that the run took: Φ, H, residuals, resets, which samples and rows were
/// accepted, and what recovery opened are those of the run, while P₀, Qd and R are affine in c, one number per parameter:
///     Qd(c) = Qd + Σ c_i ∂Qd/∂c_i .
/// c = 0 is the run itself. With x̄ the run's estimate, r̄ its residuals, δ̄ what it fed back and d the linear filter's
/// estimate less x̄,
///     r = r̄ − H d ,  d ← T (d + K r − δ̄) .
/// Where recovery scaled P, or the filter started anew, x and P are those of the run, whatever c is: the likelihood is that of
/// the pieces between.
class LinearLog {
 public:
  enum class Kind { start, step, update, variances };

  explicit LinearLog(int n) : n_(n) {}

  /// considered: per row of P; empty: none.
  void consider(std::vector<unsigned char> considered) { considered_ = std::move(considered); }

  void add_start(ConstMatrixView P);
  /// Several steps in one: Φ and what Qd became at its end.
  void add_step(const Eigen::MatrixXd& Phi, const Eigen::MatrixXd& Qd);
  /// reset null: the identity. delta: n, what the run fed back.
  void add_update(ConstMatrixView H, ConstMatrixView R, const double* residual, const double* delta,
                  ConstMatrixView reset);
  void add_variances(const double* variances);

  /// ∂P₀/∂c_i, ∂Qd/∂c_i or ∂R/∂c_i of an event, in the order of parameters, then of events.
  void begin_parameter() { terms_.emplace_back(events_.size()); }
  void add_term(std::size_t event, SparseTerm term) { terms_.back()[event] = std::move(term); }

  int parameters() const { return static_cast<int>(terms_.size()); }
  std::size_t events() const { return events_.size(); }
  Kind kind(std::size_t event) const { return events_[event].kind; }
  int rows(std::size_t event) const { return events_[event].rows; }
  /// What the event has at c = 0: P₀, Qd or R.
  ConstMatrixView noise(std::size_t event) const;
  /// Of all updates.
  int count_rows() const;
  bool has_considered() const { return !considered_.empty(); }

  /// Σ −½ (rᵀ S⁻¹ r + ln |S| + m ln 2π); −∞ where some S is not positive definite. With `gradient` (as long as c) by the
  /// co-states, exact where no component is considered:
  ///     ∂/∂Qd = ½ (λ λᵀ − Λ) at the step's end,  ∂/∂R = ½ (s sᵀ − D),  ∂/∂P₀ = ½ (λ λᵀ − Λ) at the start.
  double likelihood(std::span<const double> c, double* gradient = nullptr) const;

  /// The likelihood, its gradient and Fisher's information by sensitivities forwards: what the innovations would show of c if
  /// the noise at c were true. Of optimal gains,
  ///     I_ij = Σ ½ tr(S⁻¹ ∂S_i S⁻¹ ∂S_j) + E[ (H ∂d_i)ᵀ S⁻¹ H ∂d_j ] ,
  /// with the mean over so many draws of innovations, always the same.
  double information(std::span<const double> c, Eigen::VectorXd& gradient, Eigen::MatrixXd& information,
                     int draws = 8) const;

 private:
  struct Event {
    Kind kind;
    int rows = 0;
    bool has_reset = false;
    std::size_t at = 0;  // in numbers_
  };
  /// Of an update: what the forward pass leaves for the backward one.
  struct Innovation {
    Eigen::MatrixXd K, S, R;
    Eigen::VectorXd r;
  };
  struct Forward;
  struct Sensitivity;

  double* add(Kind kind, std::size_t doubles, int rows = 0);
  Eigen::MatrixXd noise(std::size_t event, std::span<const double> c) const;
  bool update(std::size_t event, std::span<const double> c, Forward& state) const;
  void step(std::size_t event, std::span<const double> c, Forward& state) const;
  Eigen::MatrixXd term(std::size_t event, std::size_t parameter) const;
  void update(std::size_t event, const Innovation& innovation, Sensitivity& all) const;
  void sweep(const std::vector<Innovation>& innovations, double* gradient) const;
  void add_slope(std::size_t event, const Eigen::VectorXd& v, const Eigen::MatrixXd& A, double* gradient) const;

  int n_;
  std::vector<unsigned char> considered_;
  std::vector<Event> events_;
  std::vector<double> numbers_;
  std::vector<std::vector<SparseTerm>> terms_;  // by parameter and event
};

}  // namespace binnacle::tune
