// SPDX-License-Identifier: Apache-2.0
#include "smooth/fixed_lag.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "smooth/rows.hpp"
#include "wording/wording.hpp"

namespace binnacle::smooth {

using namespace wording;

FixedLag::FixedLag(const Session& session, FilterId filter, Lag lag, Emit emit, Stretch::TakeWithheld take_withheld)
    : session_(session),
      id_(filter),
      filter_(session.composition().filters()[as_size(filter.index)]),
      lag_(lag),
      emit_(std::move(emit)),
      take_withheld_(std::move(take_withheld)),
      pattern_(filter_),
      co_states_(pattern_, considered_rows(filter_), most_rows(filter_)),
      kept_(filter_) {
  if (lag.lag < 0 || lag.every <= 0)
    throw std::invalid_argument("a lag is not negative, and sweeps are some time apart");
  if (filter_.history > 0 && session.shown() == Estimates::live)
    throw std::invalid_argument(
        "what is smoothed must be settled: a session of Estimates::settled, or a filter without history");
  open_part();
}

Wants FixedLag::wants() const { return Wants::transition | Wants::jacobian | Wants::reset | Wants::step_covariance; }

void FixedLag::open_part() {
  if (spare_.empty()) {
    spare_.emplace_back();
    spare_.back().stretch = std::make_unique<Stretch>(session_, id_, pattern_, co_states_.has_considered());
  }
  log_.push_back(std::move(spare_.back()));
  spare_.pop_back();
}

void FixedLag::started(Time t, const double* x, ConstMatrixView P) {
  newest().started(t, x, P);
  newest().mark(t, x, P);
  log_.back().end = t;
  if (next_sweep_ == no_time) next_sweep_ = t + lag_.every;
}

/// What is smoothed begins anew there.
void FixedLag::restored(Time t, const double* x, ConstMatrixView P) {
  for (Part& part : log_) {
    part.stretch->clear();
    spare_.push_back(std::move(part));
  }
  log_.clear();
  open_part();
  newest().mark(t, x, P);
  log_.back().end = t;
  next_sweep_ = t + lag_.every;
  emitted_ = no_time;
}

void FixedLag::stepped(const StepRecord& record) {
  if (next_sweep_ == no_time) next_sweep_ = record.t0 + lag_.every;  // attached on the way
  if (record.t0 >= next_sweep_) {
    sweep(record.t0 - lag_.lag);
    open_part();
    while (next_sweep_ <= record.t0) next_sweep_ += lag_.every;
  }
  newest().add_step(record);
  newest().mark(record.t1, record.x1, record.P1);
  log_.back().end = record.t1;
}

void FixedLag::offered(const UpdateRecord& record) {
  if (record.outcome == Outcome::accepted) newest().add_update(record);
  if (record.outcome == Outcome::withheld && take_withheld_) newest().withhold(record, session_.covariance(id_));
}

void FixedLag::inflated(const InflationRecord& record) { newest().inflated(record); }

void FixedLag::exchange(StateBytes& bytes) {
  std::uint64_t count = log_.size();
  bytes.value(count);
  if (!bytes.holds()) return;
  while (log_.size() < count) open_part();
  for (Part& part : log_) {
    part.stretch->exchange(bytes);
    bytes.value(part.end);
  }
  bytes.value(next_sweep_);
  bytes.value(emitted_);
  bytes.value(has_breaks_);
}

void FixedLag::finish() { sweep(std::numeric_limits<Time>::max()); }

/// Emits what came after the last emission, up to `until`, and forgets what is emitted as a whole.
void FixedLag::sweep(Time until) {
  co_states_.clear();
  for (auto part = log_.rbegin(); part != log_.rend(); ++part) {  // clang before 16 has no std::views
    if (part->end <= emitted_) break;
    part->stretch->sweep(co_states_, [&](const Epoch& epoch) { kept_.push_back(epoch); }, take_withheld_,
                         {emitted_, until});
    has_breaks_ = has_breaks_ || part->stretch->breaks() > 0;
  }
  emit_kept();
  const auto is_emitted = [&](const Part& part) { return part.end <= emitted_; };
  const auto rest = std::ranges::find_if_not(log_, is_emitted);
  for (auto part = log_.begin(); part != rest; ++part) {
    part->stretch->clear();
    spare_.push_back(std::move(*part));
  }
  log_.erase(log_.begin(), rest);
}

void FixedLag::emit_kept() {
  for (; kept_.count() > 0; kept_.pop_back()) {
    const Epoch epoch = kept_[kept_.count() - 1];
    emitted_ = epoch.t;
    emit_(epoch);
  }
}

}  // namespace binnacle::smooth
