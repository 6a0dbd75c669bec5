// SPDX-License-Identifier: Apache-2.0
// Records of a run: each filter's outputs, their 1-σ, implied states, what noise estimators made of R, local coordinates.
#pragma once

#include <memory>
#include <vector>

#include "binnacle/session.hpp"
#include "filter_score.hpp"
#include "local_columns.hpp"
#include "record_epochs.hpp"
#include "score/run.hpp"

namespace binnacle::score {

using Scores = std::vector<std::unique_ptr<FilterScore>>;

/// Outputs of all blocks, then their 1-σ.
std::vector<RecordColumn> estimate_columns(const FilterInfo& filter);

class Recorder {
 public:
  /// Shows the columns to the observer.
  Recorder(const Session& session, const Scores& scores, RunObserver& observer, const ScorePlan& plan);
  void after_instant();
  void finish();
  void exchange(StateBytes& bytes);
  /// By filter: what was recorded, once keep_times() was called.
  void keep_times() { keeps_times_ = true; }
  const std::vector<std::vector<Time>>& times() const { return times_; }

 private:
  struct Filter {
    std::size_t implied_state_columns = 0, noise_columns = 0;
    std::vector<bool> is_plain;  // by block
    LocalColumns local;
    RecordEpochs epochs;
    Time last = no_time, kept_at = no_time;
    std::vector<double> kept;  // a row that is written unless one nearer to its epoch comes
    Time open_at = no_time;
    std::vector<double> open;   // a row that is written once the filter's time is another: until then it may change
    std::int64_t changes = -1;  // FilterScore::changes() when the newest row was read
  };
  void read(std::size_t filter, Time t, std::span<double> values);
  void write_kept(std::size_t filter);
  void write_open(std::size_t filter);
  void read_again(std::size_t filter);
  void write(std::size_t filter, Time t, std::span<const double> values);

  const Session& session_;
  const Scores& scores_;
  RunObserver& observer_;
  std::vector<Filter> filters_;
  bool keeps_times_ = false;
  std::vector<std::vector<Time>> times_;
};

}  // namespace binnacle::score
