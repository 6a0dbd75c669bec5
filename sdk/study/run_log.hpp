// SPDX-License-Identifier: Apache-2.0
// RunLog: which runs of a study are still to be handed out, and what came of the others. Any thread may ask.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "batches.hpp"
#include "study/workers.hpp"

namespace binnacle::study {

class RunLog {
 public:
  RunLog(const Study& study, Results& results, const OnRun& on_run, int workers)
      : results_(results), on_run_(on_run), open_(batches_of(study.groups(), results, workers)) {
    for (const auto& batch : open_) runs_ += batch.variants.size();
  }

  /// Run by run through all variants.
  std::optional<Batch> take() {
    const std::size_t taken = next_++;
    return taken < open_.size() ? std::optional(open_[taken]) : std::nullopt;
  }
  /// How many batches were not taken yet.
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

  void enter(const Batch& batch, std::vector<Figures>&& figures) {
    for (std::size_t i = 0; i < figures.size(); ++i) enter({batch.variants[i], batch.run}, std::move(figures[i]));
  }

  bool are_complete() const { return entered_ == runs_; }
  /// Something could not be entered.
  bool have_failed() const { return has_failed_; }

 private:
  Results& results_;
  const OnRun& on_run_;
  const std::vector<Batch> open_;
  std::size_t runs_ = 0;  // in all of them
  std::atomic<std::size_t> next_{0}, entered_{0};
  std::atomic<bool> has_failed_{false};
  std::mutex one_at_a_time_;
};

}  // namespace binnacle::study
