// SPDX-License-Identifier: Apache-2.0
#include "run/runtime.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "base/hash.hpp"

namespace binnacle::internal::runtime {

namespace {

SampleWriter writer_at(double* data, const ChannelPlan& channel) {
  SampleWriter writer;
  writer.field_count = channel.epoch_fields;
  writer.row_width = channel.row_fields;
  writer.max_rows = channel.declaration.max_rows;
  writer.covariance_dof = channel.covariance_dof;
  writer.fields = data;
  writer.row_fields = data + channel.epoch_fields;
  writer.covariance = writer.row_fields + channel.row_fields * channel.declaration.max_rows;
  return writer;
}

}  // namespace

Runtime::Runtime(const CompositionPlan& plan)
    : plan_(plan), arena_(plan.layout.size() / sizeof(Line) + 1), filter_times_(plan.filters.size()) {
  for (const auto& filter : plan.filters) engines_.push_back(std::make_unique<Engine>(filter, plan.channels, arena()));
  channels_.resize(plan.channels.size());
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    channels_[c].storage.resize(plan.channels[c].doubles());
    channels_[c].slot = writer_at(channels_[c].storage.data(), plan.channels[c]);
  }
  for (const auto& subscription : plan.subscriptions) channels_[as_size(subscription.channel)].is_subscribed = true;
  for (const auto& source : plan.sources) {
    auto& slots = source_slots_.emplace_back();
    for (std::size_t i = 0; i < source.channels.size(); ++i)
      slots.push_back(writer_at(source.slots[i].in(arena()), plan.channels[as_size(source.channels[i])]));
  }
  const auto fit = [&](const std::vector<NodeInput>& inputs) {
    for (const auto& input : inputs) {
      if (input.channel < 0) continue;
      const int rows = plan.channels[as_size(input.channel)].declaration.max_rows;
      input_numbers_.resize(std::max(input_numbers_.size(), input.fields.doubles(rows)));
    }
  };
  for (const auto& transform : plan.transforms) fit(transform.inputs);
  for (const auto& sink : plan.sinks) fit(sink.inputs);
}

void Runtime::reset(std::uint64_t seed, int run) {
  std::fill(arena_.begin(), arena_.end(), Line{});
  for (auto& engine : engines_) {
    const CallScope scope(engine->calls());
    engine->reset();
  }
  for (const auto& source : plan_.sources) {
    *source.head.in(arena()) = SourceHead{};
    guard_call<FilterError>(plan_, source, "start", no_time, [&] {
      source.object->start(base::stream_seed(seed, run, source.pointer), source.memory.in(arena()));
    });
  }
  for (const auto& transform : plan_.transforms)
    guard_call<FilterError>(plan_, transform, "start", no_time, [&] {
      transform.object->start(base::stream_seed(seed, run, transform.pointer), transform.memory.in(arena()));
    });
  for (auto& channel : channels_) {
    channel.is_present = channel.is_repeated = false;
    channel.span = {};
  }
  std::fill(filter_times_.begin(), filter_times_.end(), FilterTime{});
  time_ = no_time;
}

void Runtime::deliver(int index, const SampleView& sample) {
  const auto& plan = plan_.channels[as_size(index)];
  auto& channel = channels_[as_size(index)];
  double* const data = channel.storage.data();
  channel.view = unpack(plan, pack(plan, sample, data), data);
  channel.is_present = true;
  channel.span.reach(sample.t);
}

class Runtime::TransformEmitter : public Emitter {
 public:
  TransformEmitter(Runtime& runtime, const TransformPlan& plan) : runtime_(runtime), plan_(plan) {}

  SampleWriter& on(OutputChannel channel) override {
    SampleWriter& slot = output(channel).slot;
    slot.clear();
    return slot;
  }
  void emit(OutputChannel channel) override { output(channel).publish(); }
  void emit_again(OutputChannel channel) override { output(channel).is_repeated = true; }

 private:
  Channel& output(OutputChannel channel) {
    return runtime_.channels_[as_size(plan_.channels[as_size(channel.index())])];
  }

  Runtime& runtime_;
  const TransformPlan& plan_;
};

template <class Call>
void Runtime::each_input(const std::vector<NodeInput>& inputs, Call&& call) {
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (inputs[i].channel >= 0 && channels_[as_size(inputs[i].channel)].is_present)
      call(Input(static_cast<int>(i), true),
           convert(inputs[i].fields, plan_.channels[as_size(inputs[i].channel)],
                   channels_[as_size(inputs[i].channel)].view, input_numbers_.data()));
}

void Runtime::run_transform(const TransformPlan& plan) {
  TransformEmitter emitter(*this, plan);
  each_input(plan.inputs, [&](Input input, const SampleView& sample) {
    guard_call<FilterError>(plan_, plan, "on", time_, [&] {
      plan.object->on({input, sample, plan.memory.in(arena())}, emitter);
    });
  });
}

void Runtime::run_sink(const SinkPlan& plan) {
  each_input(plan.inputs, [&](Input input, const SampleView& sample) {
    guard_call<DataError>(plan_, plan, "on", time_, [&] { plan.object->on(input, sample); });
  });
}

void Runtime::feed_filter(Engine& engine, Time t) {
  const auto& plan = engine.plan();
  bool is_touched = false;
  const auto each = [&](const auto& targets, auto push) {
    for (std::size_t i = 0; i < targets.size(); ++i)
      if (const auto& channel = channels_[as_size(targets[i].channel)]; channel.is_present) {
        push(static_cast<int>(i), channel.view);
        is_touched = true;
      }
  };
  each(plan.initial, [&](int i, const SampleView& sample) { engine.push_initial(i, sample); });
  each(plan.auxiliary, [&](int i, const SampleView& sample) { engine.push_auxiliary(i, sample); });
  if (plan.input_channel >= 0 && channels_[as_size(plan.input_channel)].is_present) {
    engine.push_input(channels_[as_size(plan.input_channel)].view);
    is_touched = true;
  }
  each(plan.measurements, [&](int i, const SampleView& sample) { engine.push_measurement(i, sample); });
  if (is_touched) engine.try_start(t);
}

/// Measures one instant of `every`, since asking a clock twice costs as much as a row of a small filter.
class Runtime::FilterWatch {
 public:
  explicit FilterWatch(FilterTime& time) : time_(time), is_due_(time.instants++ % every == 0) {
    if (is_due_) begin_ = std::chrono::steady_clock::now();
  }
  ~FilterWatch() {
    if (is_due_)
      time_.seconds += every * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  FilterWatch(const FilterWatch&) = delete;
  FilterWatch& operator=(const FilterWatch&) = delete;

 private:
  static constexpr int every = 7;  // no divisor of usual rates: measurements come at all of them
  FilterTime& time_;
  bool is_due_;
  std::chrono::steady_clock::time_point begin_;
};

void Runtime::run_filter(int index, Time t) {
  const FilterWatch watch(filter_times_[as_size(index)]);
  Engine& engine = *engines_[as_size(index)];
  const auto& plan = engine.plan();
  const bool is_heard = !plan_.channel_infos[as_size(plan.output_channel)].subscribers.empty();
  const auto accepted = [&] {
    std::int64_t count = 0;
    for (std::size_t m = 0; m < plan.measurements.size(); ++m)
      count += engine.ledger().tally(static_cast<int>(m)).by_outcome[static_cast<int>(Outcome::accepted)];
    return count;
  };
  const std::int64_t before = is_heard ? accepted() : 0;
  const CallScope scope(engine.calls());
  feed_filter(engine, t);
  Channel& output = channels_[as_size(plan.output_channel)];
  if (is_heard && engine.started() && !engine.broken() && accepted() != before && engine.write_estimates(output.slot))
    output.publish();
}

void Runtime::emit_estimates(int channel, int filter, Time t, const double* x, ConstMatrixView P) {
  Channel& output = channels_[as_size(channel)];
  Engine& engine = this->engine(filter);
  const CallScope scope(engine.calls());
  output.slot.clear();
  if (!engine.write_estimates(output.slot, t, x, P)) return;
  output.publish();
  end_instant(t);
}

void Runtime::end_instant(Time t) {
  time_ = t;
  do work_on_instant();
  while (repeat());
}

/// Whether samples of this instant come once more.
bool Runtime::repeat() {
  bool is_any = false;
  for (auto& channel : channels_)
    if (std::exchange(channel.is_repeated, false)) channel.is_present = is_any = true;
  return is_any;
}

void Runtime::work_on_instant() {
  for (const auto& node : plan_.nodes) switch (node.kind) {
      case Node::Kind::transform: run_transform(plan_.transforms[as_size(node.index)]); break;
      case Node::Kind::filter: run_filter(node.index, time_); break;
      case Node::Kind::sink:
        if (feeds_sinks_) run_sink(plan_.sinks[as_size(node.index)]);
        break;
    }
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (auto& channel = channels_[c]; std::exchange(channel.is_present, false) && channel.is_subscribed && subscriber_)
      subscriber_(static_cast<int>(c), channel.view);
}

void Runtime::fetch(std::size_t index) {
  const auto& source = plan_.sources[index];
  SourceHead& head = *source.head.in(arena());
  auto& slots = source_slots_[index];
  for (auto& slot : slots) slot.clear();
  SourceOutput out(slots.data());
  const Time previous = head.sample.t;
  const char* const call = previous == no_time ? "next for its first sample" : "next";
  const SourceStatus status = guard_call<DataError>(plan_, source, call, previous, [&] {
    return source.object->next(source.memory.in(arena()), out);
  });
  const int channel = out.channel();
  const auto fault = [&](const char* code, const std::string& what) {
    return DataError(
        Diagnostic{Severity::error, code, plan_.document.origin(source.pointer), source.pointer,
                   "source '" + source.name + "' " + what + " (" + call_text(*source.type, call, previous) + ")"});
  };
  if (status == SourceStatus::error) throw fault("B061", "cannot go on");
  if (status == SourceStatus::wait) return;  // asked again at the next instant
  if (status != SourceStatus::sample) {
    head.status = 2;
    return;
  }
  const bool is_own = channel >= 0 && as_size(channel) < slots.size();
  const SampleWriter slot = is_own ? slots[as_size(channel)] : SampleWriter{};
  if (slot.t == no_time || slot.rows < 0 || slot.rows > slot.max_rows)
    throw fault("B045", "emitted a sample that it did not declare");
  if (previous != no_time && slot.t < previous) throw fault("B063", "goes back in time, to " + time_text(slot.t));
  head = SourceHead{{slot.t, slot.t0, slot.rows, slot.has_covariance}, 1, channel};
}

bool Runtime::next_instant() {
  Time earliest = std::numeric_limits<Time>::max();
  bool has_sample = false;
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    SourceHead& head = *plan_.sources[s].head.in(arena());
    if (head.status == 0) fetch(s);
    if (head.status != 1) continue;
    has_sample = true;
    earliest = std::min(earliest, head.sample.t);
  }
  if (!has_sample) return false;
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    const auto& source = plan_.sources[s];
    SourceHead& head = *source.head.in(arena());
    while (head.status == 1 && head.sample.t == earliest) {
      const int channel = source.channels[as_size(head.channel)];
      if (channels_[as_size(channel)].is_present) break;  // a second one on this channel makes an instant of its own
      const double* data = source.slots[as_size(head.channel)].in(arena());
      deliver(channel, unpack(plan_.channels[as_size(channel)], head.sample, data));
      head.status = 0;
      fetch(s);
    }
  }
  end_instant(earliest);
  return true;
}

void Runtime::finish() {
  for (auto& engine : engines_) {
    const CallScope scope(engine->calls());
    engine->finish();
  }
}

}  // namespace binnacle::internal::runtime
