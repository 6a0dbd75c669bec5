// SPDX-License-Identifier: Apache-2.0
// Gates that refuse far more than their probability says, or that no sample ever came near.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/step_log.hpp"

namespace binnacle::score {

/// P(X ≥ k) of a binomial X of n trials with probability q each.
double binomial_tail(std::int64_t n, std::int64_t k, double q);

/// How near the samples of a filter's measurements come to their gates.
class GateWatch {
 public:
  explicit GateWatch(const FilterInfo& filter) : filter_(filter), seen_(filter.measurements.size()) {}

  void offered(const UpdateRecord& record);
  void exchange(StateBytes& bytes) { bytes.list(seen_); }
  /// One line for each gate that is not as it should be; `counts` by measurement.
  std::vector<std::string> notes(const std::vector<MeasurementCounts>& counts) const;

 private:
  struct Seen {
    std::int64_t samples = 0;  // accepted, and such that the limit is known
    double largest = 0;        // NIS over the limit
  };
  const FilterInfo& filter_;
  std::vector<Seen> seen_;
};

}  // namespace binnacle::score
