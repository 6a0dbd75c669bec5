// SPDX-License-Identifier: Apache-2.0
// Fixed-interval smoothing of the filters of a run: snapshots on the way, stretches run again backwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "binnacle/session.hpp"
#include "smooth/co_states.hpp"
#include "smooth/stretch.hpp"

namespace binnacle::smooth {

/// One filter of a run, backwards.
class SmoothedFilter {
 public:
  SmoothedFilter(Session& session, int filter);
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

 private:
  Session& session_;
  FilterId filter_;
  const FilterInfo& info_;
  TransitionPattern pattern_;
  CoStates co_states_;
  Stretch stretch_;
};

/// Memory is that of one stretch, and of snapshots: at most 64 MiB of them, or 16. Where a run is so long that they would be
/// more, stretches become longer.
class IntervalSmoother {
 public:
  /// Before the first instant. length: instants of a stretch, as long as snapshots are few.
  explicit IntervalSmoother(Session& session, std::int64_t length = 4096);

  /// After each instant of the run.
  void after_instant();

  struct Backward {
    std::vector<SmoothedFilter*> filters;
    /// After each instant of a stretch that is run again, to mark what is wanted.
    std::function<void()> each;
    /// After a stretch, the last first: to sweep its filters.
    std::function<void()> sweep;
  };
  /// In RunObserver::finished(): the whole run, stretch by stretch, and then the session as it was.
  void run_back(const Backward& backward);

 private:
  struct Snapshot {
    std::int64_t instant = 0;
    std::vector<std::byte> bytes;
  };
  void take_snapshot();

  Session& session_;
  std::vector<Snapshot> snapshots_;
  std::int64_t instants_ = 0, length_;
};

}  // namespace binnacle::smooth
