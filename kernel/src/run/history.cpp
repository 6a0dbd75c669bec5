// SPDX-License-Identifier: Apache-2.0
#include "run/history.hpp"

#include <algorithm>

#include "filter/intact.hpp"

namespace binnacle::internal::runtime {

History::History(const CompositionPlan& plan) : plan_(plan), store_(plan.channels), is_present_(plan.channels.size()) {}

void History::add(Way way) {
  const auto& nodes = way == Way::live ? plan_.history.nodes : plan_.history.settled_nodes;
  auto& runtime = way == Way::live ? live_ : settled_;
  if (!runtime) runtime = std::make_unique<Runtime>(plan_, nodes);
}

void History::reset(std::uint64_t seed, int run) {
  for (auto* runtime : {live_.get(), settled_.get()})
    if (runtime) runtime->reset(seed, run);
  store_.clear();
  dropped_.assign(plan_.channels.size(), {});
  newest_ = live_t_ = no_time;
  settled_next_ = live_next_ = 0;
  is_behind_ = is_ended_ = false;
  rewinds_ = 0;
  lag_ = {};
  refill();
  while (!snapshots_.empty()) {
    spare_.push_back(std::move(snapshots_.back()));
    snapshots_.pop_back();
  }
  if (live_) keep_snapshot();
}

void History::take(int channel, const SampleView& sample, const SampleKey& key) {
  const Time late = newest_ == no_time ? 0 : newest_ - sample.t;
  if (late > plan_.history.length || (late > 0 && is_lagging())) {
    Dropped& dropped = dropped_[base::as_size(channel)];
    ++dropped.count;
    if (late <= plan_.history.length) ++dropped.while_lagging;
    dropped.longest = std::max(dropped.longest, late);
    return;
  }
  newest_ = std::max(newest_, sample.t);
  const std::size_t at = store_.insert(key, channel, sample);
  store_[at].late = late;
  if (!live_) return;
  is_behind_ = true;
  if (at >= live_next_) return;
  if (sample.t < live_t_) return rewind(sample.t);
  // Of the time where the live way is: one more instant there.
  while (!snapshots_.empty() && snapshots_.back().t >= sample.t) {
    spare_.push_back(std::move(snapshots_.back()));
    snapshots_.pop_back();
  }
  live_next_ = store_.after(sample.t - 1);
}

/// To the newest snapshot that has nothing of that time or later in it.
void History::rewind(Time before) {
  while (snapshots_.back().t >= before) {
    spare_.push_back(std::move(snapshots_.back()));
    snapshots_.pop_back();
  }
  const Snapshot& from = snapshots_.back();
  live_->put(from.arena);
  for (std::size_t f = 0; f < from.notes.size(); ++f)
    if (Engine* engine = live_->own_engine(static_cast<int>(f))) engine->calls().note_book = from.notes[f];
  live_next_ = from.t == no_time ? 0 : store_.after(from.t);
  for (std::size_t i = live_next_; i < store_.size(); ++i) store_[i].is_live = false;
  live_t_ = from.t;
  ++rewinds_;
}

bool History::is_lagging() const { return present_lag() > plan_.history.length; }

void History::advance() {
  if (!is_behind()) return;
  for (; live_next_ < store_.size() && left_.live > 0; --left_.live) step_live();
  is_behind_ = live_next_ < store_.size();
  lag_.longest = std::max(lag_.longest, present_lag());
  if (lag_.since == no_time && is_lagging()) lag_.since = newest_;
  if (!settled_) forget();
}

void History::step_live() {
  const Time t = store_[live_next_].key.first;
  const auto deliver = [&](const SampleStore::Item& item) {
    live_->deliver(item.channel, store_.view(item), item.late);
  };
  while (each_of_instant(store_, live_next_, &SampleStore::Item::is_live, is_present_, deliver)) live_->end_instant(t);
  while (live_next_ < store_.size() && store_[live_next_].key.first == t) ++live_next_;
  live_t_ = t;
  if (snapshots_.empty() || snapshots_.back().t == no_time ||
      t - snapshots_.back().t >= plan_.history.length / HistoryPlan::snapshots)
    keep_snapshot();
}

void History::keep_snapshot() {
  if (spare_.empty()) spare_.emplace_back();
  snapshots_.push_back(std::move(spare_.back()));
  spare_.pop_back();
  Snapshot& snapshot = snapshots_.back();
  snapshot.t = live_t_;
  snapshot.arena.assign(live_->arena(), live_->arena() + live_->arena_size());
  snapshot.notes.clear();
  for (std::size_t f = 0; f < plan_.filters.size(); ++f) {
    const Engine* engine = live_->own_engine(static_cast<int>(f));
    snapshot.notes.push_back(engine ? engine->calls().note_book : NoteBook{});
  }
}

bool History::is_settled_due() const {
  return settled_ && settled_next_ < store_.size() &&
         (is_ended_ || newest_ - store_[settled_next_].key.first > plan_.history.length);
}

bool History::settle() {
  if (!is_settled_due() || (left_.settled == 0 && !is_ended_)) return false;
  --left_.settled;
  const Time t = store_[settled_next_].key.first;
  const auto deliver = [&](const SampleStore::Item& item) {
    settled_->deliver(item.channel, store_.view(item), item.late);
  };
  each_of_instant(store_, settled_next_, &SampleStore::Item::is_done, is_present_, deliver);
  settled_->end_instant(t);
  while (settled_next_ < store_.size() && store_[settled_next_].key.first == t && store_[settled_next_].is_done)
    ++settled_next_;
  forget();
  return true;
}

/// What no way needs any more, in bunches.
void History::forget() {
  constexpr std::size_t bunch = 64;
  std::size_t count = settled_ ? settled_next_ : store_.size();
  if (live_) {
    const Time until = newest_ - plan_.history.length;
    const bool has_old = snapshots_.size() > 1 && snapshots_[1].t < until;
    if (!has_old && settled_next_ < bunch) return;
    while (snapshots_.size() > 1 && snapshots_[1].t < until) {
      spare_.push_back(std::move(snapshots_.front()));
      snapshots_.erase(snapshots_.begin());
    }
    count = std::min(count, snapshots_.front().t == no_time ? 0 : store_.after(snapshots_.front().t));
  } else if (settled_next_ < bunch) {
    return;
  }
  store_.drop_front(count);
  settled_next_ -= std::min(count, settled_next_);
  live_next_ -= std::min(count, live_next_);
}

void History::finish() {
  left_.live = HistoryPlan::unbounded;
  advance();
  for (auto* runtime : {live_.get(), settled_.get()})
    if (runtime) runtime->finish();
}

void History::exchange(StateBytes& bytes) {
  for (auto* runtime : {live_.get(), settled_.get()})
    if (runtime) runtime->exchange(bytes);
  store_.exchange(bytes);
  bytes.list(dropped_);
  bytes.value(newest_);
  bytes.value(settled_next_);
  bytes.value(live_next_);
  bytes.value(live_t_);
  bytes.value(is_behind_);
  bytes.value(is_ended_);
  bytes.value(rewinds_);
  bytes.value(left_);
  bytes.value(lag_);
  std::uint64_t count = snapshots_.size();
  bytes.value(count);
  bytes.expect(count <= 2 * HistoryPlan::most_snapshots);
  if (bytes.is_reading() && bytes.holds()) snapshots_.resize(count);
  for (Snapshot& snapshot : snapshots_) {
    bytes.value(snapshot.t);
    bytes.list(snapshot.arena);
    if (bytes.is_reading()) snapshot.notes.assign(plan_.filters.size(), NoteBook{});
  }
  if (bytes.is_reading() && bytes.holds()) bytes.expect(is_intact());
}

/// Places in the store are in it; there is always a snapshot to go back to, older than what is not too late.
bool History::is_intact() const {
  using namespace filter;
  const bool has_times = is_time(newest_) && is_time(live_t_) && is_time(lag_.since) && is_length(lag_.longest) &&
                         is_count(rewinds_) && left_.live >= 0 && left_.settled > -beyond_count;
  const bool has_places = live_next_ <= store_.size() && settled_next_ <= store_.size() &&
                          (store_.empty() || newest_ != no_time) &&
                          (live_next_ == store_.size() || live_ == nullptr || is_behind_);
  if (!has_times || !has_places || dropped_.size() != plan_.channels.size()) return false;
  for (const Dropped& dropped : dropped_)
    if (!is_count(dropped.count) || !is_length(dropped.longest) || !is_count(dropped.while_lagging)) return false;
  if (!live_) return snapshots_.empty();
  if (snapshots_.empty() || snapshots_.back().t > live_t_) return false;
  const Time oldest = snapshots_.front().t;
  if (oldest != no_time && (newest_ == no_time || oldest >= newest_ - plan_.history.length)) return false;
  for (std::size_t i = 0; i < snapshots_.size(); ++i) {
    const Snapshot& its = snapshots_[i];
    if (!is_time(its.t) || (i > 0 && its.t <= snapshots_[i - 1].t)) return false;
    if (its.arena.size() != live_->arena_size()) return false;
    if (!live_->is_intact(its.arena.data())) return false;
  }
  return true;
}

void History::restored() {
  for (auto* runtime : {live_.get(), settled_.get()})
    if (runtime) runtime->restored();
}

void History::exchange_account(StateBytes& bytes) {
  for (auto* runtime : {live_.get(), settled_.get()})
    if (runtime) runtime->exchange_account(bytes);
  for (Snapshot& snapshot : snapshots_)
    for (auto& notes : snapshot.notes) notes.exchange(bytes);
}

std::size_t History::bytes() const {
  return store_.bytes() + (snapshots_.size() + spare_.size()) * (live_ ? live_->arena_size() : 0);
}

}  // namespace binnacle::internal::runtime
