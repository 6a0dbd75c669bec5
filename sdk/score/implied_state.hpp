// SPDX-License-Identifier: Apache-2.0
// A block as one measurement gives it, with the variance of that.
#pragma once

#include <vector>

#include "binnacle/state_bytes.hpp"
#include "binnacle/step_log.hpp"
#include "plan.hpp"

namespace binnacle::score {

/// The newest value of an implied state: x̂_b ⊞ B r, where B H_b = I inverts what the measurement's rows see of the block. Its
/// error is
///     truth ⊟ value = S_b δ − B (H δ + v),   S_b: the block's rows
/// with δ before the update, which does not know v: so its covariance is E P⁻ Eᵀ + B R Bᵀ, E = S_b − B H.
class ImpliedState {
 public:
  ImpliedState(const ImpliedStatePlan& plan, const BlockInfo& block);

  /// P: a priori. False where the sample gives nothing of the block, or has not become part of the estimate.
  bool take(const UpdateRecord& record, ConstMatrixView P);

  void exchange(StateBytes& bytes) {
    bytes.value(t_);
    bytes.list(value_);
    bytes.list(covariance_);
  }

  const ImpliedStatePlan& plan() const { return plan_; }
  Time t() const { return t_; }  // no_time: none yet
  const double* value() const { return value_.data(); }
  /// A row and column per estimated or considered component.
  MatrixView covariance() { return {covariance_.data(), rows_, rows_, rows_}; }

 private:
  const ImpliedStatePlan& plan_;
  const BlockInfo& block_;
  int rows_;
  Time t_ = no_time;
  std::vector<double> value_, covariance_, delta_;
};

}  // namespace binnacle::score
