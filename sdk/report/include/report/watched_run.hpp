// SPDX-License-Identifier: Apache-2.0
// WatchedRun: what is drawn of a run while it goes on, in memory that does not grow with it.
#pragma once

#include <memory>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/step_log.hpp"
#include "results/results.hpp"

namespace binnacle::report {

/// Estimates are thinned in time: of neighbours that are too many, every other goes. Of a measurement's samples those stay
/// that have the least and the greatest NIS and residuals of a stretch of time, and the first of each outcome.
///
/// Nothing is read or kept while nobody looks.
class WatchedRun {
 public:
  /// The session must live as long as take() and seen() are called.
  explicit WatchedRun(const Session& session);
  ~WatchedRun();
  WatchedRun(const WatchedRun&) = delete;
  WatchedRun& operator=(const WatchedRun&) = delete;

  /// Attach it; `next` sees the same step log; null: nobody.
  StepObserver* step_observer(int filter, StepObserver* next);
  /// Whether from here on anybody looks.
  void look(bool is_watched);
  /// After an instant: the estimates, where they are due.
  void take();
  /// As far as it was watched, with the newest estimates. Its summary: { "filters": { NAME: score::run_figures() } }, without
  /// the verdict of a filter that has not started; config and provenance are not filled in.
  results::RunResults seen() const;

 private:
  class Filter;
  const Session& session_;
  std::vector<std::unique_ptr<Filter>> filters_;
  bool is_watched_ = false;
};

}  // namespace binnacle::report
