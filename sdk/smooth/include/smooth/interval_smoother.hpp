// SPDX-License-Identifier: Apache-2.0
// Fixed-interval smoothing of the filters of a run: snapshots on the way, stretches run again backwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"
#include "smooth/co_states.hpp"
#include "smooth/path.hpp"
#include "smooth/stretch.hpp"

namespace binnacle::smooth {

/// How a filter was linearized again about its smoothed path.
struct Iterations {
  int wanted = 0;
  int done = 0;
  bool converged = false;
  double change = 0;   // the largest of the path in the last one, over its 1-sigma
  std::string reason;  // why there was none, or no further one; else empty
};

/// One filter of a run, backwards.
class SmoothedFilter {
 public:
  /// iterations: at most so many times it is linearized about the smoothed path.
  SmoothedFilter(Session& session, int filter, int iterations = 0);
  SmoothedFilter(const SmoothedFilter&) = delete;
  SmoothedFilter& operator=(const SmoothedFilter&) = delete;

  int filter() const { return filter_.index; }
  const FilterInfo& info() const { return info_; }
  Stretch& stretch() { return stretch_; }
  /// The filter's estimate as it is now is wanted smoothed.
  void mark();
  void sweep(const Stretch::Take& take, const Stretch::TakeWithheld& take_withheld);
  int breaks() const { return stretch_.breaks(); }
  bool has_considered() const { return co_states_.has_considered(); }
  const Iterations& iterations() const { return iterations_; }

 private:
  friend class IntervalSmoother;
  bool is_iterated() const { return iterations_.wanted > iterations_.done && !iterations_.converged && is_iterable_; }
  /// After the first sweep, and after each that followed: whether another one is to come.
  void settle();
  void begin_iteration();
  void end_forward();

  Session& session_;
  FilterId filter_;
  const FilterInfo& info_;
  TransitionPattern pattern_;
  CoStates co_states_;
  Stretch stretch_;
  Iterations iterations_;
  bool is_iterable_ = true;
  bool follows_ = false;                 // path_filter_ is at work
  std::vector<Decisions> decisions_of_;  // of stretches, the last first
  Decisions decisions_;
  std::unique_ptr<PathFilter> path_filter_;  // where iterations are wanted, as what follows
  std::unique_ptr<PathFile> path_, next_path_;
};

/// Memory is that of one stretch, and of snapshots: at most 64 MiB of them, or 16. Where a run is so long that they would be
/// more, stretches become longer.
class IntervalSmoother {
 public:
  /// Before the first instant. length: instants of a stretch, as long as snapshots are few.
  explicit IntervalSmoother(Session& session, std::int64_t length = 4096);

  /// After each instant of the run.
  void after_instant();
  /// For checkpoints, before run_back().
  void exchange(StateBytes& bytes);

  struct Backward {
    std::vector<SmoothedFilter*> filters;
    /// After each instant of a stretch that is run again, to mark what is wanted.
    std::function<void(SmoothedFilter&)> each;
    /// After a stretch, the last first: to sweep it.
    std::function<void(SmoothedFilter&)> sweep;
    /// What came of a filter is to be forgotten: it comes anew, linearized about that. Needed where iterations are wanted.
    std::function<void(SmoothedFilter&)> again = {};
  };
  /// In RunObserver::finished(): the whole run, stretch by stretch, and then the session as it was.
  void run_back(const Backward& backward);
  /// In RunObserver::finished(), before run_back(): the whole run again, with observers by filter, and then the session as it
  /// was.
  void run_again(const std::vector<std::pair<FilterId, StepObserver*>>& observers);

 private:
  struct Snapshot {
    std::int64_t instant = 0;
    std::vector<std::byte> bytes;
    std::map<const SmoothedFilter*, PathFilter::Snapshot> paths = {};  // of those that are iterated
  };
  void take_snapshot();
  void sweep_back(const Backward& backward);
  bool iterate(const Backward& backward);

  Session& session_;
  std::vector<Snapshot> snapshots_;
  std::int64_t instants_ = 0, length_;
};

}  // namespace binnacle::smooth
