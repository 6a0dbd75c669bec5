// SPDX-License-Identifier: Apache-2.0
// The step log: what a filter did, step by step, for smoothing, covariance analysis, scoring and plots.
#pragma once

#include <cstdint>

#include "binnacle/noise_estimator.hpp"
#include "binnacle/time.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// One propagation. Stored states are laid out as FilterInfo tells; rows of Φ and P are the estimated and considered
/// error components. P0 and P1 are there for a step observer that wants_covariance() or wants_matrices(), Phi for the latter.
struct StepRecord {
  Time t0 = no_time;
  Time t1 = no_time;
  const double* x0 = nullptr;  // a posteriori at t0
  const double* x1 = nullptr;  // a priori at t1
  MatrixView P0;
  MatrixView P1;
  MatrixView Phi;  // dense, n×n
};

/// What became of one offered sample. residual … K are there when the model was linearized; delta, x1 and P1 when the
/// sample was accepted.
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
  double nis = 0;
  MatrixView S;                   // H P⁻ Hᵀ + R
  MatrixView R;                   // as the noise estimator returned it
  const double* delta = nullptr;  // injected error, n
  const double* x0 = nullptr;
  const double* x1 = nullptr;
  MatrixView P0;  // only for a step observer that wants_matrices()
  MatrixView P1;
  MatrixView H;  // rows×n, as soon as linearized; only for a step observer that wants_matrices()
};

/// Subscribe with Session::attach(). Called inside the run loop: must not throw; what it costs, the loop costs.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  virtual bool wants_matrices() const { return false; }
  /// P before and after each step, at the price of a copy of P.
  virtual bool wants_covariance() const { return wants_matrices(); }
  /// The filter has just started: x and P are its initial values.
  virtual void started(Time /*t*/, const double* /*x*/, MatrixView /*P*/) {}
  virtual void stepped(const StepRecord& /*record*/) {}
  virtual void offered(const UpdateRecord& /*record*/) {}
};

}  // namespace binnacle
