// SPDX-License-Identifier: Apache-2.0
// One run of a composition: the arena, the engines, and the way of a sample through sources, transforms and filters.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "compose/composition_plan.hpp"
#include "filter/engine.hpp"

namespace binnacle::runtime {

using namespace compose;

class Runtime {
 public:
  explicit Runtime(const CompositionPlan& plan);

  /// Back to before the first sample; random streams are keyed by (seed, run, component).
  void reset(std::uint64_t seed, int run);

  /// The samples of one instant are delivered, at most one per channel, and then worked on together: inputs advance,
  /// then measurements in config order, transforms and filters in order of dependence.
  void deliver(int channel, const SampleView& sample);
  void end_instant(Time t);
  /// Takes the earliest instant from the sources; false when all have ended.
  bool next_instant();
  /// The end of the run.
  void finish();

  /// Shown the samples of channels that sections subscribe to, once everything at their instant has been worked on.
  using Subscriber = std::function<void(int channel, const SampleView& sample)>;
  void subscribe(Subscriber subscriber) { subscriber_ = std::move(subscriber); }

  void feed_sinks(bool wanted) { feeds_sinks_ = wanted; }

  Engine& engine(int filter) { return *engines_[static_cast<std::size_t>(filter)]; }
  const Engine& engine(int filter) const { return *engines_[static_cast<std::size_t>(filter)]; }
  const CompositionPlan& plan() const { return plan_; }
  Time time() const { return time_; }
  /// Seconds spent inside the filters.
  double filter_seconds(int filter) const { return filter_seconds_[static_cast<std::size_t>(filter)]; }
  std::int64_t samples(int source) const { return sample_counts_[static_cast<std::size_t>(source)]; }

  std::byte* arena() { return arena_.get(); }
  const std::byte* arena() const { return arena_.get(); }
  std::size_t arena_size() const { return plan_.layout.size(); }

 private:
  struct Channel {
    std::vector<double> storage;
    SampleView view;
    bool is_present = false;
  };
  class TransformEmitter;

  void fetch(std::size_t source);
  void run_filter(int index, Time t);
  void publish(Engine& engine);
  void feed_filter(Engine& engine, Time t);
  void run_transform(int index);
  void run_sink(int index);
  SampleView read_input(const NodeInput& input);

  const CompositionPlan& plan_;
  struct Free {
    void operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{Layout::alignment}); }
  };
  std::unique_ptr<std::byte[], Free> arena_;
  std::vector<std::unique_ptr<Engine>> engines_;
  std::vector<Channel> channels_;
  std::vector<std::vector<SampleWriter>> source_slots_;
  std::vector<double> input_fields_;
  std::vector<double> input_rows_;
  std::vector<SampleWriter> output_slots_;  // per channel
  std::set<int> subscribed_;
  Subscriber subscriber_;
  std::vector<double> filter_seconds_;
  std::vector<std::int64_t> sample_counts_;
  Time time_ = no_time;
  bool feeds_sinks_ = true;
};

}  // namespace binnacle::runtime
