// SPDX-License-Identifier: Apache-2.0
// Recoveries of a filter that moved its estimates far beyond what σ had said.
#pragma once

#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/step_log.hpp"

namespace binnacle::score {

/// Watches the corrections of samples for which P was opened. Allocates nothing during a run.
class JumpWatch {
 public:
  explicit JumpWatch(const FilterInfo& filter);

  /// P, as long as a gate refuses: what it was before it is opened.
  Wants wants() const { return refusing_ >= 0 ? Wants::update_covariance : Wants::nothing; }
  void inflated(const InflationRecord& record);
  void offered(const UpdateRecord& record);
  void exchange(StateBytes& bytes);

  /// The largest correction of a block by a recovery for this measurement: the norm over its components, in their unit, of
  /// those beyond 30 of its own 1-σ before P was opened. 0: there was none.
  double largest(int measurement, int block) const { return largest_[place(measurement, block)]; }

 private:
  std::size_t place(int measurement, int block) const {
    return static_cast<std::size_t>(measurement) * filter_.blocks.size() + static_cast<std::size_t>(block);
  }

  const FilterInfo& filter_;
  int refusing_ = -1;   // the measurement of which a gate refused the newest sample or rows of it
  int opened_by_ = -1;  // the measurement for which P was opened
  Time opened_at_ = no_time;
  std::vector<double> variances_;  // by block, before that: the trace
  std::vector<double> largest_;    // by measurement and block
};

}  // namespace binnacle::score
