// SPDX-License-Identifier: Apache-2.0
// The step log: what a filter did, step by step, for smoothing, covariance analysis, scoring and plots.
#pragma once

#include <cstdint>

#include "binnacle/result.hpp"
#include "binnacle/time.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// Counts of what became of a measurement's samples.
struct SampleCounts {
  std::int64_t offered = 0;
  std::int64_t by_outcome[outcome_count] = {};  // indexed by Outcome
  std::int64_t before_start = 0;                // came before the filter had its initial values
  std::int64_t recoveries = 0;
  std::int64_t rows_left_out = 0;  // of accepted samples, by a gate by row or key
  std::int64_t rows_used = 0;      // of accepted samples
  std::int64_t nis_count = 0;      // accepted samples
  std::int64_t replayed = 0;       // came late, and were applied where they belong: with `history`
  Time longest_delay = 0;          // of these
  std::int64_t iterated = 0;       // accepted samples of an iterated update
  std::int64_t iterations = 0;     // linearizations that these took together
  std::int64_t not_converged = 0;  // of these samples
  std::int64_t linearized = 0;     // samples of an unscented update, one of whose sigma points the model refused
};

/// What a step observer wants besides times, stored states, outcomes and innovations. What it does not want is not
/// computed, and null in the records.
enum class Wants : unsigned {
  nothing = 0,
  step_covariance = 1,    ///< StepRecord::P0 and P1
  transition = 2,         ///< StepRecord::Phi and Qd
  update_covariance = 4,  ///< UpdateRecord::P0 and P1, InflationRecord::P0 and P1
  jacobian = 8,           ///< UpdateRecord::H
  reset = 16,             ///< UpdateRecord::reset
  everything = 31,
};
constexpr Wants operator|(Wants a, Wants b) {
  return static_cast<Wants>(static_cast<unsigned>(a) | static_cast<unsigned>(b));
}
constexpr bool includes(Wants all, Wants part) {
  return (static_cast<unsigned>(all) & static_cast<unsigned>(part)) == static_cast<unsigned>(part);
}

// From P of the start, the records below give every P that follows, in the order in which they come:
//   started, restored   P = P
//   stepped             P ← Φ P Φᵀ + Qd
//   offered, accepted   P ← T ((I − K H) P (I − K H)ᵀ + K R Kᵀ) Tᵀ, T the reset (identity where it is null)
//   inflated            P ← P + diag(variances), or D P D with D = diag(scales)
// Nothing else changes P. Stored states are laid out as FilterInfo specifies; rows of Φ, Qd, H, K and P are the estimated
// and considered error components. All pointers are valid during the call.

/// One propagation.
struct StepRecord {
  Time t0 = no_time;
  Time t1 = no_time;
  const double* x0 = nullptr;  // a posteriori at t0
  const double* x1 = nullptr;  // a priori at t1
  ConstMatrixView P0;
  ConstMatrixView P1;
  ConstMatrixView Phi;  // dense, n×n
  ConstMatrixView Qd;   // dense, n×n, symmetric to the bit
};

/// What became of one offered sample. residual, S, R and H are there when the model was linearized; delta, K, x1 and P1
/// when the sample was accepted.
///
/// The innovation is residual and S: of the first linearization, at x0. What the correction is made of is update_residual
/// and update_S, with H, R and K: δ = K update_residual, update_S = H P⁻ Hᵀ + R. Both are the same but after an iterated
/// update: then H is that of its last linearization, at x0 ⊞ δ_j, by the error at x0, and update_residual = r_j + H δ_j; and
/// where it did not converge, δ may be less than K update_residual. After an unscented update H is the regression on the
/// sigma points, residual their mean, and R has what the regression leaves.
struct UpdateRecord {
  int measurement = 0;  // index in FilterInfo::measurements
  Time t = no_time;     // of the sample
  Outcome outcome = Outcome::rejected;
  const char* reason = "";
  int rows = 0;
  const std::int64_t* row_keys = nullptr;
  const int* row_groups = nullptr;  // which ResidualGroup of the measurement's parts, counted through, a row is of
  const double* residual = nullptr;
  int left_out = 0;  // rows that a gate by row or key took out before `rows` were left, and their keys
  const std::int64_t* left_out_keys = nullptr;
  double nis = 0;     // rᵀ S⁻¹ r; NaN where S is not positive definite
  ConstMatrixView S;  // what the residual was judged by; of nominal R where the noise estimator is judged_by_nominal()
  ConstMatrixView R;  // as the noise estimator returned it
  ConstMatrixView K;  // n×rows; rows of considered components are zero
  const double* update_residual = nullptr;
  ConstMatrixView update_S;
  const double* delta = nullptr;  // injected error, n
  const double* x0 = nullptr;
  const double* x1 = nullptr;
  ConstMatrixView P0;
  ConstMatrixView P1;     // after the reset
  ConstMatrixView H;      // rows×n
  ConstMatrixView reset;  // n×n, the reset Jacobians of the blocks; null where they are all the identity
};

/// P was opened because a measurement, or rows of it, kept being refused or biased. One recovery may be several records.
struct InflationRecord {
  int measurement = 0;
  Time t = no_time;                   // of the sample that it was opened for
  const double* variances = nullptr;  // n: added to the diagonal of P; null where the config names none
  const double* scales = nullptr;     // n: D, where D P D was made; null else
  ConstMatrixView P0;
  ConstMatrixView P1;
};

/// Subscribe with Session::attach(). Called inside the run loop: must not throw; what it costs, the loop costs.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  /// Asked before each step and each sample: the answer may change.
  virtual Wants wants() const { return Wants::nothing; }
  /// Asked before each step and each sample: a stored state that the filter is put to, to be linearized along a path that is
  /// known; null: its own. Along a path P stands still, and every sample is withheld, whatever its gate.
  virtual const double* nominal() { return nullptr; }
  /// The filter has just started: x and P are its initial values.
  virtual void started(Time /*t*/, const double* /*x*/, ConstMatrixView /*P*/) {}
  /// A late sample came, and the filter went back to t (no_time: to before its start). What was seen after t is void; the
  /// steps and samples since then come again, with it.
  virtual void rewound(Time /*t*/) {}
  /// The filter was put back to a snapshot.
  virtual void restored(Time /*t*/, const double* /*x*/, ConstMatrixView /*P*/) {}
  virtual void stepped(const StepRecord& /*record*/) {}
  virtual void offered(const UpdateRecord& /*record*/) {}
  virtual void inflated(const InflationRecord& /*record*/) {}
};

}  // namespace binnacle
