// SPDX-License-Identifier: Apache-2.0
#include "smooth/interval_smoother.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "binnacle/run.hpp"
#include "smooth/rows.hpp"
#include "wording/wording.hpp"

namespace binnacle::smooth {

using namespace wording;

namespace {

template <class Each>
struct EachInstant final : RunObserver {
  explicit EachInstant(Each call) : each(std::move(call)) {}
  void after_instant() override { each(); }
  Each each;
};

/// Why a filter cannot be linearized about a path of its own; empty: it can.
std::string why_not_iterated(const FilterInfo& filter) {
  for (const auto& measurement : filter.measurements)
    if (measurement.noise.object) return "the noise of '" + measurement.name + "' is adapted";
  return "";
}

}  // namespace

SmoothedFilter::SmoothedFilter(Session& session, int filter, int iterations)
    : session_(session),
      filter_{filter},
      info_(session.composition().filters()[as_size(filter)]),
      pattern_(info_),
      co_states_(pattern_, considered_rows(info_), most_rows(info_)),
      stretch_(session, filter_, pattern_, co_states_.has_considered()) {
  iterations_.wanted = iterations;
  if (iterations == 0) return;
  iterations_.reason = why_not_iterated(info_);
  is_iterable_ = iterations_.reason.empty();
  if (!is_iterable_) return;
  path_ = std::make_unique<PathFile>(info_.stored_size);
  next_path_ = std::make_unique<PathFile>(info_.stored_size);
  path_filter_ = std::make_unique<PathFilter>(info_, considered_rows(info_));
  stretch_.keep_path([this](const double* x) { next_path_->write(x); });
}

void SmoothedFilter::mark() {
  if (!session_.started(filter_) || !session_.healthy(filter_)) return;
  const Time t = session_.time(filter_);
  if (follows_)
    stretch_.mark(t, path_filter_->x(), path_filter_->covariance(), path_filter_->deviation());
  else
    stretch_.mark(t, session_.state(filter_).data(), session_.covariance(filter_));
}

void SmoothedFilter::sweep(const Stretch::Take& take, const Stretch::TakeWithheld& take_withheld) {
  stretch_.sweep(co_states_, take, take_withheld);
  if (path_filter_ && !follows_) decisions_of_.push_back(stretch_.decisions());
  stretch_.clear();
}

void SmoothedFilter::settle() {
  constexpr double small = 1e-3;
  if (!path_filter_) return;
  if (!follows_) {
    for (; !decisions_of_.empty(); decisions_of_.pop_back()) decisions_.append(decisions_of_.back());
    if (stretch_.was_opened()) iterations_.reason = "its covariance was opened, or it started anew";
    is_iterable_ = iterations_.reason.empty();
    return;
  }
  follows_ = false;
  ++iterations_.done;
  iterations_.change = stretch_.largest_change();
  iterations_.converged = iterations_.change < small;
}

/// Forward along the path is done: backward next, if it could be followed.
void SmoothedFilter::end_forward() {
  iterations_.reason = path_filter_->trouble();
  is_iterable_ = follows_ = iterations_.reason.empty();
  path_filter_->record_to(&stretch_);
}

void SmoothedFilter::begin_iteration() {
  std::swap(path_, next_path_);
  next_path_->clear();
  path_filter_->begin(*path_, decisions_);
  path_filter_->record_to(nullptr);
  stretch_.forget_change();
  co_states_.clear();
  follows_ = true;
}

IntervalSmoother::IntervalSmoother(Session& session, std::int64_t length) : session_(session), length_(length) {
  take_snapshot();
}

void IntervalSmoother::take_snapshot() {
  Snapshot& snapshot = snapshots_.emplace_back();
  snapshot.instant = instants_;
  snapshot.bytes.resize(session_.snapshot_size());
  session_.snapshot(snapshot.bytes);
}

void IntervalSmoother::after_instant() {
  if (++instants_ % length_ != 0) return;
  constexpr std::size_t budget = 64 << 20, least = 16;
  if (snapshots_.size() >= std::max(least, budget / snapshots_.back().bytes.size())) {
    length_ *= 2;
    std::erase_if(snapshots_, [&](const Snapshot& snapshot) { return snapshot.instant % length_ != 0; });
    if (instants_ % length_ != 0) return;
  }
  take_snapshot();
}

void IntervalSmoother::exchange(StateBytes& bytes) {
  bytes.list(snapshots_, [&](Snapshot& snapshot) {
    bytes.value(snapshot.instant);
    bytes.list(snapshot.bytes);
  });
  bytes.value(instants_);
  bytes.value(length_);
}

void IntervalSmoother::run_back(const Backward& backward) {
  std::vector<std::byte> end(session_.snapshot_size());
  session_.snapshot(end);
  for (SmoothedFilter* filter : backward.filters) session_.attach({filter->filter()}, &filter->stretch());
  sweep_back(backward);
  for (SmoothedFilter* filter : backward.filters) session_.attach({filter->filter()}, nullptr);
  for (SmoothedFilter* filter : backward.filters) filter->settle();
  while (iterate(backward)) {
  }
  session_.restore(end);
}

void IntervalSmoother::run_again(const std::vector<std::pair<FilterId, StepObserver*>>& observers) {
  std::vector<std::byte> end(session_.snapshot_size());
  session_.snapshot(end);
  for (const auto& [filter, observer] : observers) session_.attach(filter, observer);
  RunObserver none;
  rerun(session_, snapshots_.front().bytes, std::numeric_limits<std::int64_t>::max(), none);
  for (const auto& [filter, observer] : observers) session_.attach(filter, nullptr);
  session_.restore(end);
}

/// All stretches, the last first; of the snapshots the first stays.
void IntervalSmoother::sweep_back(const Backward& backward) {
  // The last call of after_instant() came after the end.
  std::erase_if(snapshots_, [&](const Snapshot& snapshot) { return snapshot.instant == instants_ && instants_ > 0; });
  std::int64_t until = std::numeric_limits<std::int64_t>::max();
  for (;; snapshots_.pop_back()) {
    const Snapshot& from = snapshots_.back();
    for (SmoothedFilter* filter : backward.filters)
      if (filter->follows_) filter->path_filter_->restore(from.paths.at(filter));
    EachInstant observer([&] {
      for (SmoothedFilter* filter : backward.filters) backward.each(*filter);
    });
    rerun(session_, from.bytes, until - from.instant, observer);
    for (SmoothedFilter* filter : backward.filters) backward.sweep(*filter);
    until = from.instant;
    if (snapshots_.size() == 1) break;
  }
}

/// One more linearization, forward and backward, of the filters that want it; false where none does.
bool IntervalSmoother::iterate(const Backward& backward) {
  std::vector<SmoothedFilter*> filters;
  for (SmoothedFilter* filter : backward.filters)
    if (filter->is_iterated()) filters.push_back(filter);
  if (filters.empty()) return false;
  const auto keep_paths = [&] {
    for (SmoothedFilter* filter : filters)
      snapshots_.back().paths.insert_or_assign(filter, filter->path_filter_->snapshot());
  };
  for (SmoothedFilter* filter : filters) {
    filter->begin_iteration();
    session_.attach({filter->filter()}, filter->path_filter_.get());
  }
  keep_paths();
  instants_ = 0;
  const std::vector<std::byte> start = snapshots_.front().bytes;
  EachInstant observer([&] {
    const std::size_t count = snapshots_.size();
    after_instant();
    if (snapshots_.size() > count) keep_paths();
  });
  rerun(session_, start, std::numeric_limits<std::int64_t>::max(), observer);
  for (SmoothedFilter* filter : filters) {
    session_.attach({filter->filter()}, nullptr);
    filter->end_forward();
  }
  std::erase_if(filters, [](const SmoothedFilter* filter) { return !filter->follows_; });
  Backward again = backward;
  again.filters = filters;
  for (SmoothedFilter* filter : filters) {
    backward.again(*filter);
    session_.attach({filter->filter()}, filter->path_filter_.get());
  }
  sweep_back(again);
  for (SmoothedFilter* filter : filters) {
    session_.attach({filter->filter()}, nullptr);
    filter->settle();
  }
  return true;
}

}  // namespace binnacle::smooth
