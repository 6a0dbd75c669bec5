// SPDX-License-Identifier: Apache-2.0
#include "run/runtime.hpp"

#include <chrono>
#include <limits>

#include "base/hash.hpp"
#include "filter/intact.hpp"
#include "run/arrival_watch.hpp"
#include "run/arrivals.hpp"
#include "run/history.hpp"
#include "run/shared_feed.hpp"

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

bool is_live_source(const SourcePlan& source) { return source.object->declaration().live; }

/// What its estimates' channel shows: each that counts is emitted.
std::int64_t emissions_of(const Engine& engine) {
  std::int64_t count = engine.plan().emits_input ? engine.status().steps : 0;
  for (std::size_t m = 0; m < engine.plan().measurements.size(); ++m)
    count += engine.ledger().tally(static_cast<int>(m)).by_outcome[static_cast<int>(Outcome::accepted)];
  return count;
}

}  // namespace

Runtime::Runtime(const CompositionPlan& plan, bool is_ordered)
    : Runtime(plan, is_ordered || plan.history.length == 0 ? plan.nodes : plan.history.arrival_nodes,
              is_ordered ? Role::all : Role::without_history) {
  is_live_ = std::ranges::any_of(plan.sources, is_live_source);
  if (Arrivals::are_wanted(plan)) arrivals_ = std::make_unique<Arrivals>(plan);
  if (plan.history.length > 0 && !is_ordered) history_ = std::make_unique<History>(plan);
  sequences_.resize(plan.sources.size() + plan.filters.size() + 1);
  emitted_.resize(plan.filters.size());
  find_places();
}

Runtime::~Runtime() = default;

Runtime::Runtime(const CompositionPlan& plan, const std::vector<Node>& nodes)
    : Runtime(plan, nodes, Role::with_history) {}

bool Runtime::is_ordered(const CompositionPlan& plan) {
  return !Arrivals::are_wanted(plan) && std::ranges::none_of(plan.sources, is_live_source) &&
         std::ranges::all_of(plan.filters, [&](const FilterPlan& filter) {
           return filter.history == 0 || plan.channel_infos[as_size(filter.settled_channel)].subscribers.empty();
         });
}

Runtime::Runtime(const CompositionPlan& plan, const std::vector<Node>& nodes, Role role)
    : plan_(plan),
      arena_(plan.layout.size() / sizeof(Line) + 1),
      nodes_(nodes),
      role_(role),
      filter_times_(plan.filters.size()) {
  engines_.resize(plan.filters.size());
  for (const Node& node : nodes) {
    if (node.kind != Node::Kind::filter) continue;
    const FilterPlan& filter = plan.filters[as_size(node.index)];
    if (role == Role::all || (role == Role::with_history) == (filter.history > 0))
      engines_[as_size(node.index)] = std::make_unique<Engine>(filter, plan.channels, arena());
  }
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
    if (!engine) continue;
    const CallScope scope(engine->calls());
    engine->reset();
  }
  for (const auto& source : plan_.sources) {
    if (role_ == Role::with_history) break;
    *source.head.in(arena()) = SourceHead{};
    guard_call<FilterError>(plan_, source, "start", no_time, [&] {
      source.object->start(base::stream_seed(seed, run, source.pointer), source.memory.in(arena()));
    });
  }
  for (const Node& node : nodes_) {
    if (node.kind != Node::Kind::transform) continue;
    const auto& transform = plan_.transforms[as_size(node.index)];
    guard_call<FilterError>(plan_, transform, "start", no_time, [&] {
      transform.object->start(base::stream_seed(seed, run, transform.pointer), transform.memory.in(arena()));
    });
  }
  for (auto& channel : channels_) {
    channel.is_present = channel.is_repeated = false;
    channel.span = {};
  }
  is_any_repeated_ = false;
  std::fill(filter_times_.begin(), filter_times_.end(), FilterTime{});
  std::ranges::fill(sequences_, 0);
  std::ranges::fill(emitted_, Emitted{});
  if (arrivals_) arrivals_->reset(seed, run);
  if (history_) history_->reset(seed, run);
  time_ = newest_live_ = no_time;
  has_live_ = false;
}

void Runtime::find_places() {
  const auto beyond = base::count_of(sequences_) - 1;
  for (auto& channel : channels_) channel.place = beyond;
  for (int s = 0; s < base::count_of(plan_.sources); ++s)
    for (const int channel : plan_.sources[as_size(s)].channels) channels_[as_size(channel)].place = s;
  for (int f = 0; f < base::count_of(plan_.filters); ++f)
    channels_[as_size(plan_.filters[as_size(f)].output_channel)].place = base::count_of(plan_.sources) + f;
}

const Runtime& Runtime::of(int filter) const {
  if (engines_[as_size(filter)]) return *this;
  return *history_->way(shown_ == Estimates::settled ? History::Way::settled : History::Way::live);
}

void Runtime::show(Estimates estimates) {
  shown_ = estimates;
  if (!history_) return;
  history_->add(estimates == Estimates::settled ? History::Way::settled : History::Way::live);
  const auto has_subscriber = [&](int channel) { return !plan_.channel_infos[as_size(channel)].subscribers.empty(); };
  for (const auto& filter : plan_.filters) {
    if (filter.history == 0) continue;
    if (has_subscriber(filter.output_channel)) history_->add(History::Way::live);
    if (has_subscriber(filter.settled_channel)) history_->add(History::Way::settled);
  }
  Runtime* const settled = history_->way(History::Way::settled);
  if (!settled) return;
  for (const auto& filter : plan_.filters)
    if (filter.history > 0) settled->channels_[as_size(filter.settled_channel)].is_subscribed = true;
  settled->subscribe([this](int channel, const SampleView& sample) {
    const bool is_estimate =
        std::ranges::any_of(plan_.filters, [&](const auto& filter) { return filter.settled_channel == channel; });
    if (!is_estimate && settled_subscriber_) settled_subscriber_(channel, sample);
    if (!is_estimate || plan_.channel_infos[as_size(channel)].subscribers.empty()) return;
    deliver(channel, sample);
    end_instant(sample.t);
  });
}

void Runtime::put(std::span<const std::byte> arena) {
  std::ranges::copy(arena, this->arena());
  for (auto& engine : engines_)
    if (engine) engine->rewound();
}

void Runtime::exchange(StateBytes& bytes) {
  bytes.exchange(arena(), arena_size());
  if (arrivals_ || history_)
    for (auto& sequence : sequences_) bytes.value(sequence);
  if (arrivals_) arrivals_->exchange(bytes);
  if (history_) bytes.list(emitted_);
  if (history_) history_->exchange(bytes);
  if (bytes.is_reading() && bytes.holds()) bytes.expect(is_intact());
}

/// Without what the history looks at itself.
bool Runtime::is_intact() const {
  const auto are_counts = [](const std::vector<std::int64_t>& counts) {
    return std::ranges::all_of(counts, filter::is_count);
  };
  return is_intact(arena()) && are_counts(sequences_) && (!history_ || emitted_.size() == plan_.filters.size()) &&
         std::ranges::all_of(emitted_, [](const Emitted& its) { return filter::is_time(its.t); }) &&
         std::ranges::all_of(engines_, [](const auto& engine) { return !engine || engine->is_sound(); });
}

bool Runtime::is_intact(const std::byte* arena) const {
  const auto is_good = [&](const SourcePlan& source) {
    const SourceHead& head = *source.head.in(arena);
    if (head.status < 0 || head.status > 2 || !filter::is_time(head.sample.t)) return false;
    if (head.status != 1) return true;
    return head.channel >= 0 && as_size(head.channel) < source.channels.size() && head.sample.t != no_time &&
           filter::is_intact(head.sample, plan_.channels[as_size(source.channels[as_size(head.channel)])]);
  };
  return std::ranges::all_of(plan_.sources, is_good) && std::ranges::all_of(engines_, [&](const auto& engine) {
           return !engine || filter::is_intact(engine->plan(), plan_.channels, arena);
         });
}

void Runtime::restored() {
  for (auto& engine : engines_)
    if (engine) engine->restored();
  if (history_) history_->restored();
}

void Runtime::exchange_account(StateBytes& bytes) {
  for (auto& channel : channels_) bytes.value(channel.span);
  bytes.list(filter_times_);
  bytes.expect(filter_times_.size() == plan_.filters.size());
  if (!bytes.holds()) filter_times_.resize(plan_.filters.size());
  bytes.value(time_);
  bytes.expect(filter::is_time(time_));
  for (auto& engine : engines_)
    if (engine) engine->calls().note_book.exchange(bytes);
  if (history_) history_->exchange_account(bytes);
}

void Runtime::deliver(int index, const SampleView& sample, Time late) {
  const auto& plan = plan_.channels[as_size(index)];
  auto& channel = channels_[as_size(index)];
  pack(plan, sample, channel.storage.data());
  const double* const covariance = sample.covariance ? channel.slot.covariance : nullptr;
  channel.view = {sample.t,   sample.t0,          sample.rows, channel.slot.fields, channel.slot.row_fields,
                  covariance, sample.t != no_time};
  channel.is_present = true;
  channel.is_taken = false;
  channel.late = late;
  if (history_) channel.sequence = sequences_[as_size(channel.place)]++;
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
  void emit(OutputChannel channel) override {
    output(channel).publish();
    output(channel).late = late;
  }
  void emit_again(OutputChannel channel) override { output(channel).is_repeated = runtime_.is_any_repeated_ = true; }

  const SampleWriter& slot(OutputChannel channel) { return output(channel).slot; }

  Time late = 0;  // of what it is made of

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

/// Passes on what a transform emits, and keeps it for others.
class Runtime::SharingEmitter : public Emitter {
 public:
  SharingEmitter(TransformEmitter& to, SharedStream& stream) : to_(to), stream_(stream) {}
  SampleWriter& on(OutputChannel channel) override { return to_.on(channel); }
  void emit(OutputChannel channel) override {
    to_.emit(channel);
    stream_.add({Item::Kind::emitted, {}, channel.index()}, &to_.slot(channel));
  }
  void emit_again(OutputChannel channel) override {
    to_.emit_again(channel);
    stream_.add({Item::Kind::again, {}, channel.index()});
  }

 private:
  using Item = SharedStream::Item;
  TransformEmitter& to_;
  SharedStream& stream_;
};

void Runtime::call_transform(const TransformPlan& plan, Tap* tap, const TransformInput& in, TransformEmitter& emitter) {
  using Item = SharedStream::Item;
  if (!tap) return guard_call<FilterError>(plan_, plan, "on", time_, [&] { plan.object->on(in, emitter); });
  if (!tap->stream->has(tap->place))
    return guard_call<FilterError>(plan_, plan, "on", time_, [&] {
      tap->stream->make([&] {
        SharingEmitter sharing(emitter, *tap->stream);
        plan.object->on({in.from, in.sample, tap->stream->memory()}, sharing);
        tap->stream->add({Item::Kind::over});
      });
      tap->place = tap->stream->end();
    });
  for (;; ++tap->place) {
    const Item& item = tap->stream->at(tap->place);
    if (item.kind == Item::Kind::over) break;
    if (item.kind == Item::Kind::again) {
      emitter.emit_again(OutputChannel(item.channel));
    } else {
      tap->stream->copy(tap->place, emitter.on(OutputChannel(item.channel)));
      emitter.emit(OutputChannel(item.channel));
    }
  }
  ++tap->place;
}

void Runtime::run_transform(std::size_t index) {
  const TransformPlan& plan = plan_.transforms[index];
  TransformEmitter emitter(*this, plan);
  Tap* const tap = taps_ && taps_->transforms[index].stream ? &taps_->transforms[index] : nullptr;
  each_input(plan.inputs, [&](Input input, const SampleView& sample) {
    emitter.late = channels_[as_size(plan.inputs[as_size(input.index())].channel)].late;
    call_transform(plan, tap, {input, sample, plan.memory.in(arena())}, emitter);
  });
}

std::byte* Runtime::memory_of(const TransformPlan& transform) {
  const auto index = static_cast<std::size_t>(&transform - plan_.transforms.data());
  SharedStream* const stream = taps_ ? taps_->transforms[index].stream : nullptr;
  return stream ? stream->memory() : transform.memory.in(arena());
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
        push(static_cast<int>(i), channel.view, plan.history > 0 ? channel.late : 0);
        is_touched = true;
      }
  };
  each(plan.initial, [&](int i, const SampleView& sample, Time late) {
    if (late <= plan.history) engine.push_initial(i, sample);
  });
  each(plan.auxiliary, [&](int i, const SampleView& sample, Time late) {
    if (late <= plan.history) engine.push_auxiliary(i, sample);
  });
  if (plan.input_channel >= 0) {
    const Channel& input = channels_[as_size(plan.input_channel)];
    if (input.is_present && (plan.history == 0 || input.late <= plan.history)) engine.push_input(input.view);
    is_touched = is_touched || input.is_present;
  }
  each(plan.measurements, [&](int i, const SampleView& sample, Time late) {
    late <= plan.history ? engine.push_measurement(i, sample, late) : engine.refuse_late(i, sample.t);
  });
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
  static constexpr int every = 61;  // no divisor of usual rates: measurements come at all of them
  FilterTime& time_;
  bool is_due_;
  std::chrono::steady_clock::time_point begin_;
};

/// What arrived in this instant.
void Runtime::give_to_history() {
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    Channel& channel = channels_[c];
    if (!channel.is_present || channel.is_taken || !plan_.history.is_root[c]) continue;
    channel.is_taken = true;
    history_->take(static_cast<int>(c), channel.view, {channel.view.t, no_time, channel.place, channel.sequence});
  }
}

/// What it emits live.
void Runtime::run_history(int index) {
  give_to_history();
  history_->advance();
  const Runtime* const live = history_->way(History::Way::live);
  const FilterPlan& plan = plan_.filters[as_size(index)];
  if (!live || plan_.channel_infos[as_size(plan.output_channel)].subscribers.empty()) return;
  Engine& engine = *live->own_engine(index);
  constexpr std::int64_t most_emissions = std::int64_t{1} << 40;
  const std::int64_t count = emissions_of(engine) + most_emissions * history_->rewinds();
  Emitted& emitted = emitted_[as_size(index)];
  if (!engine.started() || engine.broken() || count == emitted.count) return;
  // On its way back to the present it says nothing new.
  if (history_->is_behind() && engine.status().t <= emitted.t) return;
  Channel& output = channels_[as_size(plan.output_channel)];
  const CallScope scope(engine.calls());
  if (!engine.write_estimates(output.slot)) return;
  emitted = {count, engine.status().t};
  output.publish();
  output.is_taken = false;
  output.sequence = sequences_[as_size(output.place)]++;
}

void Runtime::run_filter(int index, Time t) {
  if (!engines_[as_size(index)]) return run_history(index);
  const FilterWatch watch(filter_times_[as_size(index)]);
  Engine& engine = *engines_[as_size(index)];
  const auto& plan = engine.plan();
  const int channel = role_ == Role::with_history ? plan.settled_channel : plan.output_channel;
  const bool is_heard = !plan_.channel_infos[as_size(channel)].subscribers.empty();
  const std::int64_t before = is_heard ? emissions_of(engine) : 0;
  const CallScope scope(engine.calls());
  feed_filter(engine, t);
  Channel& output = channels_[as_size(channel)];
  if (!is_heard || !engine.started() || engine.broken() || emissions_of(engine) == before) return;
  if (!engine.write_estimates(output.slot)) return;
  output.publish();
  output.is_taken = false;
  if (history_) output.sequence = sequences_[as_size(output.place)]++;
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

void Runtime::end_arrival(Time t) {
  if (history_) history_->refill();
  end_instant(t);
}

void Runtime::end_instant(Time t) {
  time_ = t;
  do work_on_instant();
  while (repeat());
}

/// Whether samples of this instant come once more.
bool Runtime::repeat() {
  if (!std::exchange(is_any_repeated_, false)) return false;
  bool is_any = false;
  for (auto& channel : channels_)
    if (std::exchange(channel.is_repeated, false)) channel.is_present = is_any = true;
  return is_any;
}

void Runtime::work_on_instant() {
  if (history_) give_to_history();
  for (const auto& node : nodes_) switch (node.kind) {
      case Node::Kind::transform: run_transform(as_size(node.index)); break;
      case Node::Kind::filter: run_filter(node.index, time_); break;
      case Node::Kind::sink:
        if (feeds_sinks_) run_sink(plan_.sinks[as_size(node.index)]);
        break;
    }
  const bool is_settled_at_once = role_ == Role::all && plan_.history.length > 0;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    if (auto& channel = channels_[c];
        std::exchange(channel.is_present, false) && channel.is_subscribed && subscriber_) {
      subscriber_(static_cast<int>(c), channel.view);
      if (is_settled_at_once && settled_subscriber_) settled_subscriber_(static_cast<int>(c), channel.view);
    }
}

bool Runtime::next_instant() {
  if (history_ && history_->settle()) return true;
  if (input_ ? next_of_input() : is_live_ ? next_of_live() : arrivals_ ? next_of_arrivals() : next_of_sources())
    return true;
  if (!history_) return false;
  if (has_live_) {  // nothing arrives now: time for what the budget left
    if (!history_->has_work()) return false;
    if (watch_) watch_->begin_idle();
    end_arrival(time_);
    return true;
  }
  history_->end();
  return history_->settle();
}

void Runtime::settle() {
  while (history_ && history_->settle()) {
  }
}

bool Runtime::next_of_arrivals() {
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    const auto& source = plan_.sources[s];
    SourceHead& head = *source.head.in(arena());
    if (head.status == 0) fetch(s);
    // Nothing of a source arrives before its time.
    while (head.status == 1 && head.sample.t <= arrivals_->next()) {
      const int channel = source.channels[as_size(head.channel)];
      const double* data = source.slots[as_size(head.channel)].in(arena());
      arrivals_->read(s, channel, unpack(plan_.channels[as_size(channel)], head.sample, data));
      head.status = 0;
      fetch(s);
    }
  }
  if (arrivals_->empty() || (watch_ && !watch_->begin_recorded(arrivals_->next()))) return false;
  const Time t = arrivals_->take_instant([&](int channel, const SampleView& sample, std::int64_t sequence) {
    deliver(channel, sample);
    channels_[as_size(channel)].sequence = sequence;
    show_arrival(channel);
  });
  end_arrival(t);
  return true;
}

void Runtime::show_arrival(int channel) const {
  const Channel& from = channels_[as_size(channel)];
  if (watch_) watch_->arrived(channel, from.view, from.sequence);
}

bool Runtime::next_of_input() {
  if ((watch_ && !watch_->begin_recorded(time_)) || !input_->next_instant()) return false;
  Time t = time_;
  while (const Arrival* arrival = input_->next()) {
    deliver(arrival->channel, *arrival->sample);
    channels_[as_size(arrival->channel)].sequence = arrival->sequence;
    show_arrival(arrival->channel);
    t = arrival->sample->t;
  }
  end_arrival(t);
  return true;
}

bool Runtime::next_of_sources() {
  Time earliest = std::numeric_limits<Time>::max();
  bool has_sample = false;
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    SourceHead& head = *plan_.sources[s].head.in(arena());
    if (head.status == 0) fetch(s);
    if (head.status != 1) continue;
    has_sample = true;
    earliest = std::min(earliest, head.sample.t);
  }
  if (!has_sample || (watch_ && !watch_->begin_recorded(earliest))) return false;
  for (std::size_t s = 0; s < plan_.sources.size(); ++s) {
    const auto& source = plan_.sources[s];
    SourceHead& head = *source.head.in(arena());
    while (head.status == 1 && head.sample.t == earliest) {
      const int channel = source.channels[as_size(head.channel)];
      if (channels_[as_size(channel)].is_present) break;  // a second one on this channel makes an instant of its own
      const double* data = source.slots[as_size(head.channel)].in(arena());
      deliver(channel, unpack(plan_.channels[as_size(channel)], head.sample, data));
      show_arrival(channel);
      head.status = 0;
      fetch(s);
    }
  }
  end_arrival(earliest);
  return true;
}

void Runtime::finish() {
  if (history_) history_->finish();
  for (auto& engine : engines_) {
    if (!engine) continue;
    const CallScope scope(engine->calls());
    engine->finish();
  }
}

}  // namespace binnacle::internal::runtime
