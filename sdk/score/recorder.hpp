// SPDX-License-Identifier: Apache-2.0
// Records of a run: each filter's outputs, their 1-σ, implied states, and what noise estimators made of R.
#pragma once

#include <memory>
#include <vector>

#include "binnacle/session.hpp"
#include "filter_score.hpp"
#include "score/run.hpp"

namespace binnacle::score {

using Scores = std::vector<std::unique_ptr<FilterScore>>;

class Recorder {
 public:
  /// Shows the columns to the observer. `every`: least time between two records; 0: after every step.
  Recorder(const Session& session, const Scores& scores, RunObserver& observer, Time every);
  void after_instant();

 private:
  struct Filter {
    std::size_t implied_state_columns = 0, noise_columns = 0;
    Time next = no_time, last = no_time;
  };
  void record(int filter, Time t);

  const Session& session_;
  const Scores& scores_;
  RunObserver& observer_;
  Time every_;
  std::vector<Filter> filters_;
  std::vector<double> values_;
};

}  // namespace binnacle::score
