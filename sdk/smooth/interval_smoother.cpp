// SPDX-License-Identifier: Apache-2.0
#include "smooth/interval_smoother.hpp"

#include <algorithm>
#include <limits>
#include <ranges>
#include <utility>

#include "binnacle/run.hpp"
#include "wording/wording.hpp"

namespace binnacle::smooth {

using namespace wording;

namespace {

/// Per row of P; empty where nothing is considered.
std::vector<unsigned char> considered_rows(const FilterInfo& filter) {
  std::vector<unsigned char> rows(as_size(filter.dof), 0);
  for (const BlockInfo& block : filter.blocks)
    for (std::size_t a = 0; a < block.active.size(); ++a)
      rows[as_size(block.first_row) + a] = block.use[as_size(block.active[a])] == "considered";
  if (std::ranges::find(rows, 1) == rows.end()) rows.clear();
  return rows;
}

int most_rows(const FilterInfo& filter) {
  int most = 1;
  for (const auto& measurement : filter.measurements) most = std::max(most, measurement.max_rows);
  return most;
}

}  // namespace

SmoothedFilter::SmoothedFilter(Session& session, int filter)
    : session_(session),
      filter_{filter},
      info_(session.composition().filters()[as_size(filter)]),
      pattern_(info_),
      co_states_(pattern_, considered_rows(info_), most_rows(info_)),
      stretch_(session, filter_, pattern_, co_states_.has_considered()) {}

void SmoothedFilter::mark() {
  if (!session_.started(filter_) || !session_.healthy(filter_)) return;
  stretch_.mark(session_.time(filter_), session_.state(filter_).data(), session_.covariance(filter_));
}

void SmoothedFilter::sweep(const Stretch::Take& take, const Stretch::TakeWithheld& take_withheld) {
  stretch_.sweep(co_states_, take, take_withheld);
  stretch_.clear();
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
  if (snapshots_.size() >= std::max(least, budget / session_.snapshot_size())) {
    length_ *= 2;
    std::erase_if(snapshots_, [&](const Snapshot& snapshot) { return snapshot.instant % length_ != 0; });
    if (instants_ % length_ != 0) return;
  }
  take_snapshot();
}

void IntervalSmoother::run_back(const Backward& backward) {
  std::vector<std::byte> end(session_.snapshot_size());
  session_.snapshot(end);
  for (SmoothedFilter* filter : backward.filters) session_.attach({filter->filter()}, &filter->stretch());
  // The last call of after_instant() came after the end.
  std::erase_if(snapshots_, [&](const Snapshot& snapshot) { return snapshot.instant == instants_; });
  std::int64_t until = std::numeric_limits<std::int64_t>::max();
  for (; !snapshots_.empty(); snapshots_.pop_back()) {
    const Snapshot& from = snapshots_.back();
    rerun(session_, from.bytes, until - from.instant, backward.each);
    backward.sweep();
    until = from.instant;
  }
  for (SmoothedFilter* filter : backward.filters) session_.attach({filter->filter()}, nullptr);
  session_.restore(end);
}

}  // namespace binnacle::smooth
