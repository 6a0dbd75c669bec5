// SPDX-License-Identifier: Apache-2.0
// When things happen in a filter: input that waits for its group, measurements that wait for the input, how intervals are
// cut, what bridges a hole, and when the filter starts. What is done then is another's work.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "binnacle/process_model.hpp"
#include "binnacle/sample.hpp"
#include "filter/plan.hpp"

namespace binnacle::internal::filter {

class TimeLine {
 public:
  /// What time brings about. Any of it may throw: the time line stays usable for flush().
  class Work {
   public:
    /// The first input sample begins: initial values.
    virtual void start(Time t) = 0;
    /// From the filter's time to t1. Without input, `samples` is empty.
    virtual void step(Time t1, std::span<const InputSample> samples) = 0;
    /// A step has been taken, and the filter's time is its end.
    virtual void stepped() = 0;
    /// A sample whose time the filter has reached.
    virtual void measure(int measurement, const SampleView& sample) = 0;
    /// The sample just offered is not used, or waits in the queue; a sample leaves the queue.
    virtual void refuse(Outcome outcome, const char* reason) = 0;
    virtual void wait() = 0;
    virtual void resume(int measurement, Time t) = 0;

   protected:
    ~Work() = default;
  };

  TimeLine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena, Work& work);

  void reset();
  const TimeHead& head() const { return head_; }
  bool is_started() const { return head_.started != 0; }
  /// Mean rates of the last driving interval, in the input channel's order; null until it has ended.
  const double* driving_rates() const { return head_.driving_rates_known ? driving_rates_ : nullptr; }

  /// The filter starts anew at the next occasion up to this time.
  void ask_restart(Time until) { head_.restart_until = until; }
  bool is_restart_due(Time t) const { return head_.restart_until != no_time && t <= head_.restart_until; }
  /// The filter starts at t, perhaps anew.
  void start(Time t);
  void input(const SampleView& sample);
  /// Of a filter that has started.
  void offer(int measurement, const SampleView& sample);
  /// The input has ended: steps what waits for its group.
  void end_input();
  /// Empties the queue: resume() for each sample, then refuse().
  void flush(Outcome outcome, const char* reason);

 private:
  bool is_increment(int field) const { return plan_.input_kinds[as_size(field)] == FieldKind::increment; }
  const ChannelPlan& channel_of(int measurement) const {
    return channels_[as_size(plan_.measurements[as_size(measurement)].channel)];
  }
  double* queued_data(int slot) const { return queue_data_ + as_size(slot) * plan_.queue_doubles; }
  void watch_repeats(const SampleView& sample);
  bool is_stepped_at_once(Time t) const;
  void step_whole(const SampleView& sample, double dt);
  bool is_complete(const SampleView& sample) const;
  bool bridge(Time until, const SampleView& sample);
  void add_pending(Time t0, Time t1, Time whole_t0, double whole_dt, const double* fields, bool bridges = false);
  /// A label far ahead moves the newest by no more than `silent`: one that is wrong does not end the input.
  void see(Time t) {
    if (head_.input_end != no_time)
      head_.newest = std::max(head_.newest, std::min(t, std::max(head_.newest, head_.input_end) + plan_.trust.silent));
  }
  void enqueue(int measurement, const SampleView& sample);
  void drain_queue(Time until);
  QueueEntry take();
  void advance_to(Time t);
  void step_pending(int whole);
  void cut(int index, Time t1, double* raw, InputSample& sample) const;
  void step(Time t1, int samples);

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  Work& work_;
  // In the arena
  TimeHead& head_;
  PendingInput* pending_;
  double* pending_fields_;
  double* last_input_;
  double* driving_rates_;
  QueueEntry* queue_;
  double* queue_data_;
  std::vector<InputSample> samples_;   // of one step
  std::vector<double> sample_fields_;  // theirs, raw
  std::vector<int> used_fields_;       // of the input: they must be finite
};

}  // namespace binnacle::internal::filter
