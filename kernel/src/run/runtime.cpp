// SPDX-License-Identifier: Apache-2.0
#include "run/runtime.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <limits>
#include <new>

#include "base/hash.hpp"
#include "base/index.hpp"
#include "run/guard_call.hpp"

namespace binnacle::runtime {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

using base::as_size;

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

std::string time_text(Time t) {
  char text[48];
  std::snprintf(text, sizeof text, "%.9g s", seconds(t));
  return text;
}

}  // namespace

Runtime::Runtime(const CompositionPlan& plan) : plan_(plan) {
  arena_.reset(static_cast<std::byte*>(
      ::operator new[](std::max<std::size_t>(plan.layout.size(), 1), std::align_val_t{Layout::alignment})));
  std::memset(arena_.get(), 0, plan.layout.size());
  for (const auto& filter : plan.filters)
    engines_.push_back(std::make_unique<Engine>(filter, plan.channels, arena_.get()));
  filter_seconds_.assign(plan.filters.size(), 0.0);
  sample_counts_.assign(plan.sources.size(), 0);

  channels_.resize(plan.channels.size());
  output_slots_.resize(plan.channels.size());
  for (std::size_t c = 0; c < plan.channels.size(); ++c) {
    const auto& channel = plan.channels[c];
    channels_[c].storage.assign(std::max<std::size_t>(channel.doubles(), 1), 0.0);
    output_slots_[c] = writer_at(channels_[c].storage.data(), channel);
  }
  for (const auto& source : plan.sources) {
    std::vector<SampleWriter> slots;
    for (std::size_t i = 0; i < source.channels.size(); ++i) {
      const auto& channel = plan.channels[as_size(source.channels[i])];
      slots.push_back(writer_at(source.slots[i].in(arena_.get()), channel));
    }
    source_slots_.push_back(std::move(slots));
  }
  std::size_t fields = 1, rows = 1;
  const auto widen = [&](const std::vector<NodeInput>& inputs) {
    for (const auto& input : inputs) {
      fields = std::max(fields, input.fields.epoch.size());
      if (input.channel >= 0)
        rows = std::max(rows,
                        input.fields.row.size() * as_size(plan.channels[as_size(input.channel)].declaration.max_rows));
    }
  };
  for (const auto& transform : plan.transforms) widen(transform.inputs);
  for (const auto& sink : plan.sinks) widen(sink.inputs);
  input_fields_.assign(fields, 0.0);
  input_rows_.assign(rows, 0.0);

  for (const auto& subscription : plan.subscriptions) subscribed_.insert(subscription.channel);
}

void Runtime::reset(std::uint64_t seed, int run) {
  std::memset(arena_.get(), 0, plan_.layout.size());
  for (auto& engine : engines_) {
    const CallScope scope(engine->call_site());
    engine->reset();
  }
  for (const auto& source : plan_.sources) {
    *source.head.in(arena_.get()) = SourceHead{};
    guard_call<FilterError>(plan_, source, "start", no_time, [&] {
      source.source->start(base::stream_seed(seed, run, source.pointer), source.memory.in(arena_.get()));
    });
  }
  for (const auto& transform : plan_.transforms)
    guard_call<FilterError>(plan_, transform, "start", no_time, [&] {
      transform.transform->start(base::stream_seed(seed, run, transform.pointer), transform.memory.in(arena_.get()));
    });
  for (auto& channel : channels_) channel.is_present = false;
  std::fill(filter_seconds_.begin(), filter_seconds_.end(), 0.0);
  std::fill(sample_counts_.begin(), sample_counts_.end(), 0);
  time_ = no_time;
}

void Runtime::deliver(int index, const SampleView& sample) {
  const auto& plan = plan_.channels[as_size(index)];
  auto& channel = channels_[as_size(index)];
  const auto& slot = output_slots_[as_size(index)];
  channel.view = sample;
  channel.view.available = true;
  channel.view.fields = slot.fields;
  channel.view.row_fields = slot.row_fields;
  std::copy_n(sample.fields, plan.epoch_fields, slot.fields);
  if (plan.row_fields > 0) std::copy_n(sample.row_fields, plan.row_fields * sample.rows, slot.row_fields);
  if (sample.covariance) {
    std::copy_n(sample.covariance, plan.covariance_dof * plan.covariance_dof, slot.covariance);
    channel.view.covariance = slot.covariance;
  }
  channel.is_present = true;
}

SampleView Runtime::read_input(const NodeInput& input) {
  const auto& channel = channels_[as_size(input.channel)];
  SampleView view = channel.view;
  read_fields(input.fields, channel.view, view.t0 == no_time ? 0.0 : seconds(view.t - view.t0), input_fields_.data());
  read_row_fields(input.fields, plan_.channels[as_size(input.channel)], channel.view, input_rows_.data());
  view.fields = input_fields_.data();
  view.row_fields = input_rows_.data();
  return view;
}

class Runtime::TransformEmitter : public Emitter {
 public:
  TransformEmitter(Runtime& runtime, const TransformPlan& plan) : runtime_(runtime), plan_(plan) {}

  SampleWriter& on(OutputChannel channel) override {
    SampleWriter& slot = runtime_.output_slots_[as_size(plan_.channels[as_size(channel.index())])];
    slot.clear();
    return slot;
  }
  void emit(OutputChannel channel) override {
    const int index = plan_.channels[as_size(channel.index())];
    const SampleWriter& slot = runtime_.output_slots_[as_size(index)];
    auto& output = runtime_.channels_[as_size(index)];
    output.view = SampleView{slot.t,      slot.t0,         slot.rows,
                             slot.fields, slot.row_fields, slot.has_covariance ? slot.covariance : nullptr,
                             true};
    output.is_present = true;
  }

 private:
  Runtime& runtime_;
  const TransformPlan& plan_;
};

void Runtime::run_transform(int index) {
  const auto& transform = plan_.transforms[as_size(index)];
  TransformEmitter emitter(*this, transform);
  for (std::size_t i = 0; i < transform.inputs.size(); ++i) {
    const auto& input = transform.inputs[i];
    if (input.channel < 0 || !channels_[as_size(input.channel)].is_present) continue;
    guard_call<FilterError>(plan_, transform, "on", time_, [&] {
      transform.transform->on({Input(static_cast<int>(i), true), read_input(input), transform.memory.in(arena_.get())},
                              emitter);
    });
  }
}

void Runtime::run_sink(int index) {
  const auto& sink = plan_.sinks[as_size(index)];
  for (std::size_t i = 0; i < sink.inputs.size(); ++i)
    if (sink.inputs[i].channel >= 0 && channels_[as_size(sink.inputs[i].channel)].is_present)
      guard_call<DataError>(plan_, sink, "on", time_,
                            [&] { sink.sink->on(Input(static_cast<int>(i), true), read_input(sink.inputs[i])); });
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
  if (is_touched && !engine.started()) engine.try_start(t);
}

void Runtime::publish(Engine& engine) {
  const auto channel = as_size(engine.plan().output_channel);
  SampleWriter& slot = output_slots_[channel];
  if (!engine.write_estimates(slot)) return;
  channels_[channel].view = SampleView{slot.t, slot.t0, 0, slot.fields, slot.row_fields, slot.covariance, true};
  channels_[channel].is_present = true;
}

void Runtime::run_filter(int index, Time t) {
  const auto begin = std::chrono::steady_clock::now();
  Engine& engine = *engines_[as_size(index)];
  const auto& plan = engine.plan();
  const bool is_heard = !plan_.channel_infos[as_size(plan.output_channel)].subscribers.empty();
  const auto accepted = [&] {
    std::int64_t count = 0;
    for (std::size_t m = 0; m < plan.measurements.size(); ++m)
      count += engine.tally(static_cast<int>(m)).outcomes[static_cast<int>(Outcome::accepted)];
    return count;
  };
  const std::int64_t before = is_heard ? accepted() : 0;
  const CallScope scope(engine.call_site());
  feed_filter(engine, t);
  if (is_heard && engine.started() && !engine.broken() && accepted() != before) publish(engine);
  filter_seconds_[as_size(index)] += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Runtime::end_instant(Time t) {
  time_ = t;
  for (const auto& node : plan_.nodes) switch (node.kind) {
      case Node::Kind::transform: run_transform(node.index); break;
      case Node::Kind::filter: run_filter(node.index, t); break;
      case Node::Kind::sink:
        if (feeds_sinks_) run_sink(node.index);
        break;
    }
  if (subscriber_)
    for (const int channel : subscribed_)
      if (channels_[as_size(channel)].is_present) subscriber_(channel, channels_[as_size(channel)].view);
  for (auto& channel : channels_) channel.is_present = false;
}

void Runtime::fetch(std::size_t index) {
  const auto& source = plan_.sources[index];
  SourceHead& head = *source.head.in(arena_.get());
  auto& slots = source_slots_[index];
  for (auto& slot : slots) slot.clear();
  SourceOutput out(slots.data());
  const Time previous = head.t;
  const char* const call = previous == no_time ? "next for its first sample" : "next";
  const SourceStatus status = guard_call<DataError>(plan_, source, call, previous, [&] {
    return source.source->next(source.memory.in(arena_.get()), out);
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
  if (channel < 0 || as_size(channel) >= slots.size() || slots[as_size(channel)].t == no_time ||
      slots[as_size(channel)].rows < 0 ||
      slots[as_size(channel)].rows > plan_.channels[as_size(source.channels[as_size(channel)])].declaration.max_rows)
    throw fault("B045", "emitted a sample that it did not declare");
  const auto& slot = slots[as_size(channel)];
  if (previous != no_time && slot.t < previous) throw fault("B063", "goes back in time, to " + time_text(slot.t));
  head = SourceHead{slot.t, slot.t0, 1, channel, slot.rows, slot.has_covariance};
  ++sample_counts_[index];
}

bool Runtime::next_instant() {
  Time earliest = std::numeric_limits<Time>::max();
  bool has_sample = false;
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    SourceHead& head = *plan_.sources[s].head.in(arena_.get());
    if (head.status == 0) fetch(s);
    if (head.status != 1) continue;
    has_sample = true;
    earliest = std::min(earliest, head.t);
  }
  if (!has_sample) return false;
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    const auto& source = plan_.sources[s];
    SourceHead& head = *source.head.in(arena_.get());
    while (head.status == 1 && head.t == earliest) {
      const int channel = source.channels[as_size(head.channel)];
      if (channels_[as_size(channel)].is_present) break;  // a second one on this channel makes an instant of its own
      const SampleWriter& slot = source_slots_[s][as_size(head.channel)];
      SampleView view{head.t,      head.t0,         head.rows,
                      slot.fields, slot.row_fields, head.has_covariance ? slot.covariance : nullptr,
                      true};
      deliver(channel, view);
      head.status = 0;
      fetch(s);
    }
  }
  end_instant(earliest);
  return true;
}

void Runtime::finish() {
  for (auto& engine : engines_) {
    const CallScope scope(engine->call_site());
    engine->finish();
  }
}

}  // namespace binnacle::runtime
