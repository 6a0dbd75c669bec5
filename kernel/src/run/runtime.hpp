// SPDX-License-Identifier: Apache-2.0
// One run of a composition: the arena, the engines, and the way of a sample through sources, transforms and filters.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/catalog.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/run.hpp"
#include "binnacle/state_bytes.hpp"
#include "compose/composition_plan.hpp"
#include "filter/engine.hpp"

namespace binnacle::internal::runtime {

using namespace compose;

/// "plugin 'csv', component 'csv': next at 12.3 s", for faults that are no exception.
inline std::string call_text(const ComponentType& type, const char* call_name, Time t) {
  CallSite site;
  site.enter(&type.plugin, type.spec.type, call_name);
  site.set_time(t);
  return site.text();
}

/// Calls a source, a transform or a sink: what escapes becomes an error at its place that names plugin, component, call and
/// sample. `component`: a SourcePlan, TransformPlan or SinkPlan. Throws RunError (DataError, FilterError): the run ends.
template <class RunError, class ComponentPlan, class Call>
auto guard_call(const CompositionPlan& plan, const ComponentPlan& component, const char* call_name, Time t,
                Call&& call) {
  try {
    return component.type->guarded(call_name, std::forward<Call>(call), t);
  } catch (const ComponentError& error) {
    if (error.is_data_error())
      throw RunError(Diagnostic{Severity::error, error.code(), Origin{error.file(), error.line(), 0}, component.pointer,
                                error.what()});
    // A ComponentError that the component made itself does not say which call it came from.
    std::string message = error.what();
    if (const std::string who = call_text(*component.type, call_name, t); !message.starts_with(who))
      message = who + " threw: " + message;
    throw RunError(
        Diagnostic{Severity::error, "B045", plan.document.origin(component.pointer), component.pointer, message});
  }
}

class History;
class Arrivals;
class ArrivalWatch;
class SharedStream;
struct Tap;
struct Taps;

class Runtime {
 public:
  /// Of a whole run. is_ordered: nothing can be late, so that history has nothing to do.
  explicit Runtime(const CompositionPlan& plan, bool is_ordered = false);
  /// Of a history: these nodes alone, without sources.
  Runtime(const CompositionPlan& plan, const std::vector<Node>& nodes);
  ~Runtime();

  /// Back to before the first sample; random streams are keyed by (seed, run, component).
  void reset(std::uint64_t seed, int run);

  /// The samples of one instant are delivered, at most one per channel, and then worked on together: inputs advance,
  /// then measurements in config order, transforms and filters in order of dependence.
  /// late: how much older it is than what had come, for filters with history.
  void deliver(int channel, const SampleView& sample, Time late = 0);
  void end_instant(Time t);
  /// The same for what arrived from outside, which filters with history may work for.
  void end_arrival(Time t);
  /// After what was pushed: filters with history settle what is due.
  void settle();
  /// Takes the earliest instant from the sources, or what that settles, instant by instant; false when all have ended and
  /// are settled.
  bool next_instant();
  /// Whether that false means that live sources have nothing yet.
  bool waits() const { return has_live_; }
  /// Until one of them may have something, or for some milliseconds.
  void wait_for_sources();
  /// Nothing is asked of the sources any more.
  void end_sources();
  /// The end of the run.
  void finish();
  /// Sees what arrives; null: nobody.
  void watch(ArrivalWatch* watch) { watch_ = watch; }
  /// In place of the sources.
  void read_from(RecordedInput* input) { input_ = input; }
  /// Sources and transforms that have a stream there give what is in it. Before the first instant.
  void read_from(Taps* taps) { taps_ = taps; }
  /// Samples come once.
  bool is_live() const { return is_live_ || input_ || taps_; }
  /// Whether samples of recorded sources come in order of time, and nobody waits for what is settled.
  static bool is_ordered(const CompositionPlan& plan);
  /// Estimates of a filter, not its own ones, as an instant of their own.
  void emit_estimates(int channel, int filter, Time t, const double* x, ConstMatrixView P);

  /// Shown the samples of channels that sections subscribe to, once everything at their instant has been worked on.
  using Subscriber = std::function<void(int channel, const SampleView& sample)>;
  void subscribe(Subscriber subscriber) { subscriber_ = std::move(subscriber); }
  /// The same in order of time, as they are settled; there are none without a filter with history.
  void subscribe_settled(Subscriber subscriber) { settled_subscriber_ = std::move(subscriber); }

  void feed_sinks(bool wanted) { feeds_sinks_ = wanted; }

  /// What engine(), and all else that asks for a filter, gives of filters with history. Before the first sample.
  void show(Estimates estimates);
  /// Where the filter runs.
  const Runtime& of(int filter) const;
  Runtime& of(int filter) { return const_cast<Runtime&>(std::as_const(*this).of(filter)); }
  Engine& engine(int filter) const { return *of(filter).engines_[as_size(filter)]; }
  /// Null: it runs elsewhere.
  Engine* own_engine(int filter) const { return engines_[as_size(filter)].get(); }
  const History* history() const { return history_.get(); }
  const Arrivals* arrivals() const { return arrivals_.get(); }
  const CompositionPlan& plan() const { return plan_; }
  Time time() const { return time_; }
  /// Of what came on a channel; from no_time: nothing.
  struct Span {
    Time from = no_time, to = no_time;
    void reach(Time t) {
      if (from == no_time) from = t;
      to = std::max(to, t);  // a stretch may be run again
    }
  };
  const Span& span(int channel) const { return channels_[as_size(channel)].span; }
  /// Spent inside a filter, estimated from one instant in seven.
  struct FilterTime {
    std::int64_t instants = 0;
    double seconds = 0;
  };
  std::vector<FilterTime>& filter_times() { return filter_times_; }
  const std::vector<FilterTime>& filter_times() const { return filter_times_; }

  std::byte* arena() { return arena_.data()->bytes; }
  const std::byte* arena() const { return arena_.data()->bytes; }
  /// Of the transform that works for this run.
  std::byte* memory_of(const TransformPlan& transform);
  std::size_t arena_size() const { return plan_.layout.size(); }
  /// The arena as it was; step observers are informed.
  void put(std::span<const std::byte> arena);
  bool has_more_than_arena() const { return arrivals_ || history_; }
  /// All that outlives an instant. What is read back is refused, by `bytes`, where it is no state to go on from.
  void exchange(StateBytes& bytes);
  /// After all was read back: step observers are informed.
  void restored();
  /// Whether an arena, this runtime's own or one that it had, is one to go on from.
  bool is_intact(const std::byte* arena) const;
  /// What is reported of a run besides: spans, times, notes.
  void exchange_account(StateBytes& bytes);

 private:
  struct alignas(Layout::alignment) Line {
    std::byte bytes[Layout::alignment];
  };
  /// The newest sample on a channel.
  struct Channel {
    std::vector<double> storage;
    SampleWriter slot;  // over the storage
    SampleView view;
    Span span;
    bool is_present = false;   // in this instant
    bool is_repeated = false;  // it comes once more
    bool is_subscribed = false;
    bool is_taken = false;  // by the history
    std::int32_t place = 0;
    std::int64_t sequence = 0;  // of the newest sample, at its place
    Time late = 0;

    /// What was written to the slot is the sample of this instant.
    void publish() {
      const double* const covariance = slot.has_covariance ? slot.covariance : nullptr;
      view = {slot.t, slot.t0, slot.rows, slot.fields, slot.row_fields, covariance, true};
      is_present = true;
      span.reach(slot.t);
    }
  };
  /// Which filters run here.
  enum class Role { all, without_history, with_history };
  Runtime(const CompositionPlan& plan, const std::vector<Node>& nodes, Role role);
  bool is_intact() const;
  class TransformEmitter;
  class SharingEmitter;
  class FilterWatch;
  void fetch(std::size_t source);
  SourceStatus ask(std::size_t source, const char* call, SourceOutput& out);
  SourceStatus ask_shared(std::size_t source, const char* call, Tap& tap, SourceOutput& out);
  SourceStatus make_shared(std::size_t source, const char* call, SharedStream& stream, SourceOutput& out);
  void run_filter(int index, Time t);
  void feed_filter(Engine& engine, Time t);
  void run_transform(std::size_t transform);
  void call_transform(const TransformPlan& plan, Tap* tap, const TransformInput& in, TransformEmitter& emitter);
  void run_sink(const SinkPlan& plan);
  void work_on_instant();
  bool repeat();
  void find_places();
  bool next_of_sources();
  bool next_of_arrivals();
  bool next_of_live();
  bool next_of_input();
  /// To the watch: what was delivered.
  void show_arrival(int channel) const;
  void give_to_history();
  void run_history(int filter);
  /// Reads what is present in this instant.
  template <class Call>
  void each_input(const std::vector<NodeInput>& inputs, Call&& call);

  const CompositionPlan& plan_;
  std::vector<Line> arena_;
  std::vector<std::unique_ptr<Engine>> engines_;
  std::vector<Channel> channels_;
  std::vector<std::vector<SampleWriter>> source_slots_;
  std::vector<double> input_numbers_;  // of what is being read
  bool is_any_repeated_ = false;       // of the channels
  const std::vector<Node>& nodes_;
  Role role_;
  std::unique_ptr<Arrivals> arrivals_;
  std::unique_ptr<History> history_;
  Estimates shown_ = Estimates::live;
  std::vector<std::int64_t> sequences_;  // by place
  /// What a filter's live channel shows.
  struct Emitted {
    std::int64_t count = 0;  // of what changed its estimates
    Time t = no_time;
  };
  std::vector<Emitted> emitted_;  // by filter with history
  Subscriber subscriber_, settled_subscriber_;
  std::vector<FilterTime> filter_times_;
  Time time_ = no_time;
  bool feeds_sinks_ = true;
  bool is_live_ = false;   // a source is
  bool has_live_ = false;  // and has not ended
  Time newest_live_ = no_time;
  ArrivalWatch* watch_ = nullptr;
  RecordedInput* input_ = nullptr;
  Taps* taps_ = nullptr;
};

}  // namespace binnacle::internal::runtime
