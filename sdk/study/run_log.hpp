// SPDX-License-Identifier: Apache-2.0
// RunLog: which runs of a study are still to be handed out, and what came of the others. Any thread may ask.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "study/workers.hpp"

namespace binnacle::study {

class RunLog {
 public:
  RunLog(const Study& study, Results& results, const OnRun& on_run) : results_(results), on_run_(on_run) {
    for (std::size_t run = 0; run < results.runs(); ++run)
      for (std::size_t variant = 0; variant < study.variants().size(); ++variant)
        if (results.at(variant, run).state == Figures::State::open) open_.push_back({variant, run});
  }

  /// Run by run through all variants.
  std::optional<RunKey> take() {
    const std::size_t taken = next_++;
    return taken < open_.size() ? std::optional(open_[taken]) : std::nullopt;
  }
  /// How many were not taken yet.
  std::size_t left() const {
    const std::size_t next = next_;
    return next < open_.size() ? open_.size() - next : 0;
  }

  void enter(RunKey key, Figures&& figures) {
    const std::lock_guard lock(one_at_a_time_);
    try {
      on_run_(key.variant, key.run, figures);
    } catch (...) {
      has_failed_ = true;
      throw;
    }
    results_.at(key.variant, key.run) = std::move(figures);
    ++entered_;
  }

  bool are_complete() const { return entered_ == open_.size(); }
  /// Something could not be entered.
  bool have_failed() const { return has_failed_; }

 private:
  Results& results_;
  const OnRun& on_run_;
  std::vector<RunKey> open_;
  std::atomic<std::size_t> next_{0}, entered_{0};
  std::atomic<bool> has_failed_{false};
  std::mutex one_at_a_time_;
};

}  // namespace binnacle::study
