// SPDX-License-Identifier: Apache-2.0
// Filters with history: samples that are late by no more than it are applied where they belong.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "run/arrivals.hpp"
#include "run/runtime.hpp"

namespace binnacle::internal::runtime {

/// Two ways through the same samples, either of which may be missing. The *settled* one works on them in order of time, once
/// none can come any more that is late by no more than the history: it is an ordinary run over ordered samples. The *live* one
/// works on each as it arrives; for a late one it goes back to the newest snapshot before it, and works again on all since.
class History {
 public:
  enum class Way { live, settled };

  explicit History(const CompositionPlan& plan);

  void add(Way way);
  /// Null: it is missing.
  Runtime* way(Way way) const { return (way == Way::live ? live_ : settled_).get(); }
  void reset(std::uint64_t seed, int run);

  /// A sample arrived on a root channel. It is not kept where it is too late.
  void take(int channel, const SampleView& sample, const SampleKey& key);
  /// An instant arrived, or there is time to spare: each way may work on so many instants as the budget allows.
  void refill() { left_ = {plan_.history.steps, plan_.history.steps}; }
  /// The live way works on what arrived.
  void advance();
  /// The settled way works on one instant, if one is due.
  bool settle();
  /// The budget left something undone.
  bool has_work() const { return is_behind() || is_settled_due(); }
  /// Samples arrived that the live way has not worked on.
  bool is_behind() const { return live_ && is_behind_; }
  /// Nothing will arrive any more.
  void end() { is_ended_ = true; }
  void finish();
  void exchange(StateBytes& bytes);
  void exchange_account(StateBytes& bytes);
  void restored();

  /// Samples that came too late for any filter.
  struct Dropped {
    std::int64_t count = 0;
    Time longest = 0;                // how late
    std::int64_t while_lagging = 0;  // of the count
  };
  const Dropped& dropped(int channel) const { return dropped_[base::as_size(channel)]; }
  std::int64_t rewinds() const { return rewinds_; }
  /// How far the live way is behind what has arrived, after each instant.
  struct Lag {
    Time longest = 0;
    Time since = no_time;  // the newest sample when it first was more than the history
  };
  const Lag& lag() const { return lag_; }
  std::size_t bytes() const;

 private:
  struct Snapshot {
    Time t = no_time;  // all up to there is in it
    std::vector<std::byte> arena;
    std::vector<NoteBook> notes;
  };

  struct Budget {
    std::int64_t live = 0, settled = 0;
  };

  void rewind(Time before);
  /// Whether late samples must be refused, so that the live way catches up.
  bool is_lagging() const;
  Time present_lag() const { return is_behind() ? newest_ - store_[live_next_].key.first : 0; }
  bool is_settled_due() const;
  /// Works on all samples of the next time.
  void step_live();
  void keep_snapshot();
  void forget();
  bool is_intact() const;

  const CompositionPlan& plan_;
  std::unique_ptr<Runtime> live_, settled_;
  SampleStore store_;
  std::vector<bool> is_present_;
  std::vector<Dropped> dropped_;  // by channel
  Time newest_ = no_time;         // of a sample that arrived
  std::size_t settled_next_ = 0;  // of the store
  std::size_t live_next_ = 0;
  Time live_t_ = no_time;
  bool is_behind_ = false, is_ended_ = false;
  std::vector<Snapshot> snapshots_, spare_;  // of the live way, in order of time
  std::int64_t rewinds_ = 0;
  Budget left_;
  Lag lag_;
};

}  // namespace binnacle::internal::runtime
