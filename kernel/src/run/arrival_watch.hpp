// SPDX-License-Identifier: Apache-2.0
// Runs that go by the clock: recorded data at a pace, when samples arrived, how long they took.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "binnacle/run.hpp"
#include "run/latency_histogram.hpp"
#include "run/runtime.hpp"

namespace binnacle::internal::runtime {

class ArrivalWatch {
 public:
  /// Whether a run needs one.
  static bool is_wanted(const CompositionPlan& plan, const RunOptions& options, const RunObserver& observer);
  ArrivalWatch(Runtime& runtime, const RunOptions& options, RunObserver& observer);
  ~ArrivalWatch() { runtime_.watch(nullptr); }
  ArrivalWatch(const ArrivalWatch&) = delete;
  ArrivalWatch& operator=(const ArrivalWatch&) = delete;

  // ---- for the runtime

  /// An instant of recorded data, which arrives at t: at a pace, once it is due. False: the observer wants to stop.
  bool begin_recorded(Time t);
  /// An instant of a sample that a live source gives now.
  void begin_live(std::size_t source);
  /// An instant that only goes on with what is left.
  void begin_idle();
  void arrived(int channel, const SampleView& sample, std::int64_t sequence);

  // ---- for the run

  /// All that the instant brings about is done.
  void end_instant();
  LiveFigures figures() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Channel {
    LatencyHistogram latencies;
    Time newest = no_time;
    std::int64_t samples = 0, behind = 0;
    bool is_present = false;  // in this instant
  };

  /// Since the run began.
  Time now() const { return std::chrono::nanoseconds(Clock::now() - begin_).count(); }
  /// Every instant has an arrival of its own.
  void begin(Time came);

  Runtime& runtime_;
  RunObserver& observer_;
  double pace_;
  bool wants_arrivals_;
  bool is_stopping_ = false;
  Clock::time_point begin_ = Clock::now();
  std::vector<std::unique_ptr<Channel>> channels_;  // null: nothing arrived on it
  std::vector<LiveFigures::Source> sources_;        // by source of the plan
  Time came_ = 0;                                   // of the instant at work
  Time at_ = 0;                                     // the same, growing
  Time first_ = no_time, first_at_ = 0;             // at a pace: of the data, and when that was
  Time first_came_ = no_time;
};

}  // namespace binnacle::internal::runtime
