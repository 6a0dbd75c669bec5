// SPDX-License-Identifier: Apache-2.0
// First samples that contradict the initial state: a wrong initial value, or an initial sigma that is too small.
#pragma once

#include <string>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/step_log.hpp"

namespace binnacle::score {

/// How the first sample of each of a filter's measurements agrees with the estimate.
class StartWatch {
 public:
  explicit StartWatch(const FilterInfo& filter) : filter_(filter), first_(filter.measurements.size()) {}

  void offered(const UpdateRecord& record);
  void exchange(StateBytes& bytes) { bytes.list(first_); }
  /// One line for each measurement whose first sample a right filter meets with a probability below 1e-9. `start`: of the
  /// filter.
  std::vector<std::string> notes(Time start) const;

 private:
  struct First {
    Time t = no_time;  // none yet
    double nis = 0;
    int rows = 0;
    int group = 0;  // of the row that is farthest out
    std::int64_t key = 0;
    double residual = 0, sigma = 0;
  };
  bool starts_from_other_quantity(const MeasurementInfo& measurement) const;

  const FilterInfo& filter_;
  std::vector<First> first_;
};

}  // namespace binnacle::score
