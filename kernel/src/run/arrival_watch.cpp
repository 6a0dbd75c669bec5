// SPDX-License-Identifier: Apache-2.0
#include "run/arrival_watch.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

namespace binnacle::internal::runtime {

using base::as_size;

namespace {

/// How long the observer is not asked whether to stop [ns].
constexpr Time longest_sleep = 50'000'000;

bool has_live_source(const CompositionPlan& plan) {
  return std::ranges::any_of(plan.sources, [](const auto& source) { return source.object->declaration().live; });
}

/// Until an instant of the monotonic clock, or a signal.
void sleep_until(std::chrono::steady_clock::time_point until) {
  const auto left = std::chrono::nanoseconds(until.time_since_epoch()).count();
  const timespec at{static_cast<std::time_t>(left / nanoseconds_per_second),
                    static_cast<long>(left % nanoseconds_per_second)};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

}  // namespace

bool ArrivalWatch::is_wanted(const CompositionPlan& plan, const RunOptions& options, const RunObserver& observer) {
  return options.pace > 0 || observer.wants_arrivals() || (!options.input && has_live_source(plan));
}

ArrivalWatch::ArrivalWatch(Runtime& runtime, const RunOptions& options, RunObserver& observer)
    : runtime_(runtime), observer_(observer), pace_(options.pace), wants_arrivals_(observer.wants_arrivals()) {
  channels_.resize(runtime.plan().channels.size());
  for (const auto& source : runtime.plan().sources) sources_.push_back({source.name, 0, 0, 0});
  runtime.watch(this);
}

bool ArrivalWatch::begin_recorded(Time t) {
  if (pace_ > 0) {
    if (std::exchange(first_, first_ == no_time ? t : first_) == no_time) first_at_ = now();
    const Time due = first_at_ + static_cast<Time>(static_cast<double>(t - first_) / pace_);
    for (Time left = 0; !is_stopping_ && (left = due - now()) > 0;) {
      is_stopping_ = !observer_.progress(runtime_.time());
      if (!is_stopping_) sleep_until(begin_ + std::chrono::nanoseconds(now() + std::min(left, longest_sleep)));
    }
    if (is_stopping_) return false;
    begin(due);
  } else {
    begin(now());
  }
  return true;
}

void ArrivalWatch::begin_live(std::size_t source) {
  const SourceFigures figures = runtime_.plan().sources[source].object->figures();
  auto& own = sources_[source];
  own.longest_queue = std::max(own.longest_queue, figures.waiting);
  own.lost = figures.lost;
  own.unusable = figures.unusable;
  begin(figures.arrival == no_time ? now()
                                   : figures.arrival - std::chrono::nanoseconds(begin_.time_since_epoch()).count());
}

void ArrivalWatch::begin_idle() {
  begin(now());
  if (wants_arrivals_) observer_.arrived({.at = at_});
}

void ArrivalWatch::begin(Time came) {
  came_ = came;
  if (first_came_ == no_time) first_came_ = came;
  at_ = std::max(at_ + 1, came);
}

void ArrivalWatch::arrived(int channel, const SampleView& sample, std::int64_t sequence) {
  auto& own = channels_[as_size(channel)];
  if (!own) own = std::make_unique<Channel>();
  ++own->samples;
  own->is_present = true;
  if (own->newest != no_time && sample.t < own->newest) ++own->behind;
  own->newest = std::max(own->newest, sample.t);
  if (wants_arrivals_) observer_.arrived({at_, channel, &sample, sequence});
}

void ArrivalWatch::end_instant() {
  const Time latency = now() - came_;
  for (auto& channel : channels_)
    if (channel && std::exchange(channel->is_present, false)) channel->latencies.add(latency);
}

LiveFigures ArrivalWatch::figures() const {
  LiveFigures figures;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (const Channel* channel = channels_[c].get())
      figures.channels.push_back({runtime_.plan().channels[c].name, channel->samples, channel->behind,
                                  seconds(channel->latencies.quantile(0.5)), seconds(channel->latencies.quantile(0.99)),
                                  seconds(channel->latencies.longest())});
  for (std::size_t s = 0; s < sources_.size(); ++s)
    if (runtime_.plan().sources[s].object->declaration().live) figures.sources.push_back(sources_[s]);
  figures.seconds = first_came_ == no_time ? 0 : seconds(now() - first_came_);
  return figures;
}

}  // namespace binnacle::internal::runtime
