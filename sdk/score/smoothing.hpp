// SPDX-License-Identifier: Apache-2.0
// Smooths filters of a run, once it is over, and scores and records what comes of it as of any filter.
#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/session.hpp"
#include "filter_score.hpp"
#include "local_columns.hpp"
#include "plan.hpp"
#include "score/run.hpp"
#include "smooth/fixed_lag.hpp"
#include "smooth/interval_smoother.hpp"

namespace binnacle::score {

/// Smoothed epochs of one filter as they come, in a file without a name.
class EpochFile {
 public:
  explicit EpochFile(const FilterInfo& filter);
  void write(const smooth::Epoch& epoch);
  std::int64_t count() const { return count_; }
  /// In the order in which they were written. What is shown lasts until the next call.
  smooth::Epoch read(std::int64_t index);
  void clear();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::int64_t count_ = 0;
  int dof_;
  std::size_t stored_size_;
  std::vector<double> record_, P_;  // t, x, the lower triangle of P
};

/// All smoothed filters of a run.
class Smoothing {
 public:
  /// Before the run.
  Smoothing(const ScorePlan& plan, Session& session, RunObserver& observer, bool records);

  // ---- during the run
  /// Of the filters that it is for.
  void sampled(int channel, const SampleView& sample, const std::function<bool(int filter)>& is_of);
  void after_instant() { smoother_.after_instant(); }
  void exchange(StateBytes& bytes);

  /// At its end. recorded: by filter, the times of what was recorded. The session is left as it was.
  void finish(const std::vector<std::vector<Time>>& recorded);
  bool is_running_again() const { return is_running_again_; }

  /// By ScorePlan::smoothings.
  FilterScore& score(std::size_t index) const { return *filters_[index]->score; }
  nlohmann::ordered_json summary(std::size_t index) const;

 private:
  /// A reference sample, to be shown once more.
  struct Reference {
    int channel = 0;
    Time t = no_time, t0 = no_time;
    std::vector<double> fields;
  };
  struct Filter {
    Filter(const ScorePlan& plan, const SmoothingPlan& smoothing, Session& session);
    const SmoothingPlan& plan;
    const FilterInfo& info;
    const LocalColumns local;
    std::unique_ptr<smooth::SmoothedFilter> backward;  // of a fixed interval
    std::unique_ptr<smooth::FixedLag> lag;
    std::unique_ptr<FilterScore> score;
    EpochFile epochs;
    std::vector<Reference> references;
    std::vector<Time> wanted;  // of references
    std::vector<smooth::WithheldSample> withheld;
    std::span<const Time> recorded;
    Time marked = no_time;
    smooth::Epoch last;  // of the lag: what was emitted last, in last_x and last_P
    std::vector<double> last_x, last_P;
    bool is_written = false;
  };
  void smooth_with_lag();
  void smooth_intervals();
  void mark(Filter& filter);
  void replay(Filter& filter);
  void record(const Filter& filter, const smooth::Epoch& epoch);

  Session& session_;
  RunObserver& observer_;
  bool records_;
  bool is_running_again_ = false;
  smooth::IntervalSmoother smoother_;
  std::vector<std::unique_ptr<Filter>> filters_;
  std::vector<double> row_, sigma_scratch_;
};

}  // namespace binnacle::score
