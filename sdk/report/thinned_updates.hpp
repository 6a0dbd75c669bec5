// SPDX-License-Identifier: Apache-2.0
// ThinnedUpdates: the samples of one measurement, in memory that does not grow with their number.
#pragma once

#include "binnacle/composition.hpp"
#include "binnacle/step_log.hpp"
#include "results/results.hpp"

namespace binnacle::report {

class ThinnedUpdates {
 public:
  static constexpr std::size_t most_samples = 4096;
  static constexpr std::size_t most_rows = 16384;

  explicit ThinnedUpdates(const MeasurementInfo& info, std::size_t samples = most_samples,
                          std::size_t rows = most_rows);
  void add(const UpdateRecord& record);
  /// What came after t [s] is void.
  void rewind(double t);
  /// Without reasons.
  const results::Updates& updates() const { return updates_; }

 private:
  bool is_full() const;
  void thin();
  void keep(const std::vector<std::size_t>& samples);

  results::Updates updates_;
  std::size_t sample_limit_, row_limit_;
  double width_ = 0;  // of the stretches of time that are thinned so far [s]; 0: none is
};

}  // namespace binnacle::report
