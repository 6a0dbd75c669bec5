// SPDX-License-Identifier: Apache-2.0
// The life of a filter: start, input, time, queue. What an update does stands in update.cpp, a step in step.cpp.
#include "filter/engine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

namespace binnacle {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr const char* broken_reason = "the filter is broken";

std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

}  // namespace

int read_fields(const FieldMap& map, const SampleView& sample, double dt, double* epoch) {
  int missing = -1;
  for (const auto& item : map.epoch) {
    double value = item.index < 0 ? not_a_number : sample.fields[item.index];
    if (item.required && !std::isfinite(value) && missing < 0) missing = item.declared;
    if (item.conversion == FieldMap::Conversion::to_rate) value /= dt;
    if (item.conversion == FieldMap::Conversion::to_increment) value *= dt;
    *epoch++ = value;
  }
  return missing;
}

void read_row_fields(const FieldMap& map, const ChannelPlan& channel, const SampleView& sample, double* rows) {
  for (int row = 0; row < sample.rows; ++row)
    for (const auto& item : map.row)
      *rows++ = item.index < 0 ? not_a_number : sample.row_fields[row * channel.row_fields + item.index];
}

Engine::Engine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena)
    : plan_(plan), channels_(channels), arena_(arena), outlier_test_(plan.max_rows) {
  const auto n = as_size(plan.n), ld = as_size(padded(plan.n));
  const auto m = as_size(plan.max_rows), k = as_size(plan.max_columns);
  const auto group = as_size(plan.samples_per_step);
  workspace_.assign(plan.workspace, 0.0);
  for (const auto one : plan.ones) workspace_[one] = 1.0;
  values_.resize(as_size(plan.value_count()));
  for (std::size_t i = 0; i < plan.blocks.size(); ++i)
    values_[i] = plan_.state.in(arena_) + plan.blocks[i].stored_offset;
  for (std::size_t i = 0; i < plan.derived.size(); ++i)
    values_[plan.blocks.size() + i] = workspace_.data() + plan.derived[i].value;
  for (const auto offset : plan.transition_blocks) phi_.push_back(workspace_.data() + offset);
  for (const auto offset : plan.noise_blocks) noise_.push_back(workspace_.data() + offset);
  x_plus_.assign(as_size(plan.stored_size), 0.0);
  predict_scratch_.assign(predict_scratch(plan.transition), 0.0);

  std::size_t ports = 1, dof = 1, auxiliaries = 1, memory = 1, auxiliary_doubles = 1, drives = 1;
  for (const auto& block : plan.blocks) dof = std::max(dof, as_size(block.dof()));
  for (const auto& process : plan.processes) ports = std::max(ports, process.ports.size());
  for (const auto& derived : plan.derived) {
    ports = std::max(ports, derived.ports.size());
    drives = std::max(drives, derived.driving_rates.size());
  }
  for (const auto& measurement : plan.measurements) {
    memory = std::max(memory, measurement.memory_bytes + measurement.noise_memory.count);
    for (const auto& part : measurement.parts) {
      ports = std::max(ports, part.ports.size());
      drives = std::max(drives, part.driving_rates.size());
      auxiliaries = std::max(auxiliaries, part.auxiliary.size());
      std::size_t doubles = 0;
      for (std::size_t i = 0; i < part.auxiliary.size(); ++i) {
        const auto& map = part.auxiliary_fields[i];
        const int index = part.auxiliary[i];
        const int rows = index < 0 ? 0 : channels[as_size(plan.auxiliary[as_size(index)].channel)].declaration.max_rows;
        doubles += map.epoch.size() + map.row.size() * as_size(rows);
      }
      auxiliary_doubles = std::max(auxiliary_doubles, doubles);
    }
  }
  port_values_.assign(ports, nullptr);
  port_outputs_.assign(ports, nullptr);
  jacobians_.assign(ports, MatrixView{});
  driving_rate_fields_.assign(drives, 0.0);
  auxiliary_views_.assign(auxiliaries, SampleView{});
  auxiliary_fields_.assign(auxiliary_doubles, 0.0);
  memory_backup_.assign(memory, std::byte{});

  samples_.resize(group);
  model_samples_.resize(group);
  sample_fields_.assign(group * as_size(std::max(1, plan.input_fields)), 0.0);
  model_fields_.assign(group * as_size(std::max(1, plan.max_fields)), 0.0);
  gathered_.assign(as_size(std::max(1, plan.max_fields)), 0.0);
  gathered_rows_.assign(as_size(std::max(1, plan.max_row_fields)), 0.0);

  H_.assign(m * k, 0.0);
  for (auto* square : {&R_, &HPHt_, &S_, &L_, &R_nominal_}) square->assign(m * m, 0.0);
  for (auto* column : {&r_, &y_, &post_fit_}) column->assign(m, 0.0);
  for (auto* tall : {&G_, &K_, &U_}) tall->assign(ld * std::max<std::size_t>(m, 3), 0.0);
  delta_.assign(n, 0.0);
  row_keys_.assign(m, 0);
  row_groups_.assign(m, 0);
  left_out_keys_.assign(m, 0);
  left_out_groups_.assign(m, 0);
  block_delta_.assign(dof, 0.0);
  block_reset_.assign(2 * dof * dof, 0.0);
  reset_scratch_.assign(ld * dof, 0.0);
  x_before_.assign(as_size(plan.stored_size), 0.0);
  work_ = UpdateWork{plan.max_rows, H_.data(), R_.data(), r_.data(), G_.data(), HPHt_.data(),
                     S_.data(),     L_.data(), K_.data(), U_.data(), y_.data()};
}

void Engine::attach(StepObserver* observer) {
  observer_ = observer;
  if (observer) {
    P_before_.assign(as_size(padded(plan_.n)) * as_size(plan_.n), 0.0);
    Phi_dense_.assign(as_size(plan_.n) * as_size(plan_.n), 0.0);
    int most_rows = 0;
    for (const auto& measurement : plan_.measurements) most_rows = std::max(most_rows, measurement.max_rows);
    H_dense_.assign(as_size(most_rows) * as_size(plan_.n), 0.0);
  }
}

void Engine::reset() {
  head() = FilterHead{};
  for (std::int32_t i = 0; i < plan_.queue_capacity; ++i) {
    plan_.queue.in(arena_)[i] = QueueEntry{};
    plan_.queue.in(arena_)[i].slot = i;
  }
  std::fill_n(x(), plan_.stored_size, 0.0);
  std::fill_n(P(), as_size(padded(plan_.n)) * as_size(plan_.n), 0.0);
  for (const auto& process : plan_.processes)
    if (process.memory.count > 0) {
      std::memset(process.memory.in(arena_), 0, process.memory.count);
      process.model->start(process.memory.in(arena_));
    }
  for (const auto& measurement : plan_.measurements) {
    *measurement.ledger.in(arena_) = Ledger{};
    std::fill_n(measurement.left_out.in(arena_), measurement.left_out.count, LeftOut{});
    if (measurement.noise && measurement.noise_memory.count > 0) {
      std::memset(measurement.noise_memory.in(arena_), 0, measurement.noise_memory.count);
      measurement.noise->start(measurement.noise_memory.in(arena_));
    }
    for (const auto& part : measurement.parts)
      if (part.memory.count > 0) {
        std::memset(part.memory.in(arena_), 0, part.memory.count);
        part.model->start(part.memory.in(arena_));
      }
  }
  for (const auto* list : {&plan_.initial, &plan_.auxiliary})
    for (const auto& latest : *list) {
      std::fill_n(latest.data.in(arena_), latest.data.count, not_a_number);
      std::fill_n(latest.times.in(arena_), 2, no_time);
      std::fill_n(latest.state.in(arena_), 3, 0);
    }
}

void Engine::fail(const std::string& diagnosis) {
  std::strncpy(head().diagnosis, diagnosis.c_str(), sizeof head().diagnosis - 1);
  head().broken = 1;
}

void Engine::stop_for_exception(const char* what) {
  char time[48];
  std::snprintf(time, sizeof time, " at %.9g s: ", seconds(head().t));
  if (in_process_ >= 0) conclude(in_process_, head().t, Outcome::rejected, "its plugin threw", 0, 0, false, nullptr);
  fail("'" + (component_ ? *component_ : std::string("a plugin")) + "' threw in " + call_ + time + what);
}

namespace {

void keep_latest(const LatestPlan& plan, const ChannelPlan& channel, const SampleView& sample, std::byte* arena) {
  double* data = plan.data.in(arena);
  const auto epoch = as_size(channel.epoch_fields);
  const auto rows = as_size(channel.row_fields) * as_size(sample.rows);
  std::copy_n(sample.fields, epoch, data);
  if (rows > 0) std::copy_n(sample.row_fields, rows, data + epoch);
  const auto square = as_size(channel.covariance_dof) * as_size(channel.covariance_dof);
  if (sample.covariance) std::copy_n(sample.covariance, square, data + plan.data.count - square);
  plan.times.in(arena)[0] = sample.t;
  plan.times.in(arena)[1] = sample.t0;
  std::int32_t* state = plan.state.in(arena);
  state[0] = sample.rows;
  state[1] = sample.covariance != nullptr;
  state[2] = 1;
}

}  // namespace

SampleView Engine::latest(const LatestPlan& plan) const {
  const auto& channel = channels_[as_size(plan.channel)];
  const double* data = plan.data.in(arena_);
  const std::int32_t* state = plan.state.in(arena_);
  SampleView view;
  view.available = state[2] != 0;
  view.t = plan.times.in(arena_)[0];
  view.t0 = plan.times.in(arena_)[1];
  view.rows = state[0];
  view.fields = data;
  view.row_fields = data + channel.epoch_fields;
  if (state[1])
    view.covariance = data + plan.data.count - as_size(channel.covariance_dof) * as_size(channel.covariance_dof);
  return view;
}

void Engine::push_auxiliary(int auxiliary, const SampleView& sample) {
  const auto& plan = plan_.auxiliary[as_size(auxiliary)];
  keep_latest(plan, channels_[as_size(plan.channel)], sample, arena_);
}

void Engine::push_initial(int initial, const SampleView& sample) {
  if (started()) return;
  const auto& plan = plan_.initial[as_size(initial)];
  for (int i = 0; i < channels_[as_size(plan.channel)].epoch_fields; ++i)
    for (const auto& block : plan_.blocks)
      if (block.initial.channel == initial &&
          std::find(block.initial.fields.begin(), block.initial.fields.end(), i) != block.initial.fields.end() &&
          !std::isfinite(sample.fields[i]))
        return;
  keep_latest(plan, channels_[as_size(plan.channel)], sample, arena_);
}

void Engine::try_start(Time t) {
  if (started() || broken() || plan_.initial.empty()) return;
  for (const auto& initial : plan_.initial) {
    const SampleView view = latest(initial);
    if (!view.available || (initial.max_age > 0 && t - view.t > initial.max_age)) return;
  }
  start_blocks(t);
}

void Engine::start_blocks(Time t) {
  auto& h = head();
  const int ld = padded(plan_.n);
  std::vector<double>& outputs = predict_scratch_;  // free until the first step
  for (const auto& block : plan_.blocks) {
    double* value = x() + block.stored_offset;
    const auto& initial = block.initial;
    if (initial.channel < 0) {
      std::copy(initial.value.begin(), initial.value.end(), value);
    } else {
      const SampleView view = latest(plan_.initial[as_size(initial.channel)]);
      const auto count = block.declaration().outputs.size();
      if (outputs.size() < count) outputs.resize(count);
      for (std::size_t i = 0; i < count; ++i) outputs[i] = view.fields[initial.fields[i]];
      calling(block.type, "write");
      const Result result = block.block->write(outputs.data(), value);
      if (!result) {
        fail("block '" + block.name + "' refuses its initial value: " + result.reason);
        return;
      }
    }
  }
  for (const auto& block : plan_.blocks)
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const auto component = as_size(block.active[a]);
      const int row = block.first + static_cast<int>(a);
      const double sigma = block.initial.sigma[component];
      if (std::isfinite(sigma)) {
        P()[row + row * ld] = sigma * sigma;
        continue;
      }
      const SampleView view = latest(plan_.initial[as_size(block.initial.channel)]);
      const int dof = channels_[as_size(plan_.initial[as_size(block.initial.channel)].channel)].covariance_dof;
      if (!view.covariance) {
        fail("block '" + block.name + "' takes its initial sigma from a sample without covariance");
        return;
      }
      for (const auto& other : plan_.blocks) {
        if (other.initial.channel != block.initial.channel || other.initial.covariance.empty()) continue;
        for (std::size_t b = 0; b < other.active.size(); ++b) {
          const auto other_component = as_size(other.active[b]);
          if (std::isfinite(other.initial.sigma[other_component])) continue;
          const int column = other.first + static_cast<int>(b);
          P()
          [row + column * ld] =
              view.covariance[block.initial.covariance[component] + other.initial.covariance[other_component] * dof];
        }
      }
    }
  h.t = h.start = t;
  h.input_end = t;
  h.started = 1;
  h.just_started = 1;
  check_health();
  if (observer_ && !broken()) observer_->started(t, x(), covariance());
}

void Engine::push_input(const SampleView& sample) {
  auto& h = head();
  if (h.broken) return;
  for (int i = 0; i < plan_.input_fields; ++i)
    if (plan_.input_used[as_size(i)] && !std::isfinite(sample.fields[i])) {
      ++h.gaps;
      return;
    }
  if (!h.started) {
    if (!plan_.initial.empty()) return;
    start_blocks(sample.t0 == no_time ? sample.t : sample.t0);
    if (sample.t0 == no_time || h.broken) return;
  }
  if (sample.t <= h.input_end) {
    if (sample.t < h.input_end) ++h.gaps;
    return;
  }
  const bool has_interval = sample.t0 != no_time;
  const Time t0 = has_interval ? sample.t0 : h.input_end;
  const double dt = seconds(sample.t - t0);
  if (h.just_started && t0 < h.input_end) {
    add_pending(h.input_end, sample.t, t0, dt, sample.fields);
  } else {
    // A whole sample missing: the rates are held over the hole, and it is counted.
    if (!has_interval || t0 - h.input_end >= sample.t - t0) {
      if (!h.just_started || t0 > h.input_end) ++h.gaps;
      const Time until = has_interval ? t0 : sample.t;
      // The bridge is no sample of the sensor: it is stepped alone, never in a group with its neighbours.
      if (h.pending > 0) step_pending(h.pending);
      if (h.broken) return;
      bool rates_only = true;
      for (int i = 0; i < plan_.input_fields; ++i)
        rates_only = rates_only && plan_.input_kinds[as_size(i)] != FieldKind::increment;
      const double hole = seconds(until - h.input_end);
      if (rates_only) {
        add_pending(h.input_end, until, h.input_end, hole, sample.fields);
      } else if (h.driving_rates_known) {
        double* fields = sample_fields_.data();
        for (int i = 0; i < plan_.input_fields; ++i)
          fields[i] =
              plan_.driving_rates.in(arena_)[i] * (plan_.input_kinds[as_size(i)] == FieldKind::increment ? hole : 1.0);
        add_pending(h.input_end, until, h.input_end, hole, fields);
      } else {
        fail("the first input sample after the start has no interval, so its increments have no rate");
        return;
      }
      drain_queue(until);
      if (!h.broken && h.pending > 0) step_pending(h.pending);
      if (h.broken) return;
    }
    if (sample.t > h.input_end) add_pending(h.input_end, sample.t, h.input_end, dt, sample.fields);
  }
  h.just_started = 0;
  drain_queue(sample.t);
  if (!h.broken && h.pending >= plan_.samples_per_step) step_pending(h.pending);
}

void Engine::add_pending(Time t0, Time t1, Time whole_t0, double whole_dt, const double* fields) {
  auto& h = head();
  // Room is for samples_per_step whole samples; what is older is stepped first.
  if (h.pending == static_cast<int>(plan_.pending.count)) step_pending(h.pending);
  plan_.pending.in(arena_)[h.pending] = PendingInput{t0, t1, whole_t0, t1, whole_dt};
  std::copy_n(fields, plan_.input_fields, plan_.pending_fields.in(arena_) + h.pending * plan_.input_fields);
  ++h.pending;
  h.input_end = t1;
}

void Engine::advance_to(Time t) {
  auto& h = head();
  if (plan_.input_channel < 0) {
    if (t > h.t) step(t, 0);
    return;
  }
  PendingInput* pending = plan_.pending.in(arena_);
  int whole = 0;
  while (whole < h.pending && pending[whole].t1 <= t) ++whole;
  if (whole > 0) step_pending(whole);
  if (!h.broken && h.pending > 0 && pending[0].t0 < t) step_fragment(t);
}

void Engine::enqueue(int measurement, const SampleView& sample) {
  auto& h = head();
  QueueEntry* queue = plan_.queue.in(arena_);
  if (h.queued == plan_.queue_capacity) {
    conclude(measurement, sample.t, Outcome::rejected, "the queue of samples ahead of the input is full", 0, 0, false,
             nullptr);
    return;
  }
  // Slots are a permutation kept behind the entries in use.
  const std::int32_t slot = queue[h.queued].slot;
  int at = h.queued;
  const auto before = [&](const QueueEntry& other) {
    return sample.t < other.t || (sample.t == other.t && measurement < other.measurement);
  };
  while (at > 0 && before(queue[at - 1])) {
    queue[at] = queue[at - 1];
    --at;
  }
  queue[at] =
      QueueEntry{sample.t, sample.t0, h.sequence++, measurement, sample.rows, sample.covariance != nullptr, slot};
  ++h.queued;
  const auto& channel = channels_[as_size(plan_.measurements[as_size(measurement)].channel)];
  double* data = plan_.queue_data.in(arena_) + as_size(slot) * plan_.queue_doubles;
  data = std::copy_n(sample.fields, channel.epoch_fields, data);
  if (channel.row_fields > 0) std::copy_n(sample.row_fields, channel.row_fields * sample.rows, data);
  data += channel.row_fields * channel.declaration.max_rows;
  if (sample.covariance) std::copy_n(sample.covariance, channel.covariance_dof * channel.covariance_dof, data);
}

void Engine::drain_queue(Time until) {
  auto& h = head();
  QueueEntry* queue = plan_.queue.in(arena_);
  while (!h.broken && h.queued > 0 && queue[0].t <= until) {
    const QueueEntry entry = queue[0];
    const auto& channel = channels_[as_size(plan_.measurements[as_size(entry.measurement)].channel)];
    const double* data = plan_.queue_data.in(arena_) + as_size(entry.slot) * plan_.queue_doubles;
    SampleView sample;
    sample.t = entry.t;
    sample.t0 = entry.t0;
    sample.rows = entry.rows;
    sample.fields = data;
    sample.row_fields = data + channel.epoch_fields;
    if (entry.has_covariance)
      sample.covariance = data + channel.epoch_fields + channel.row_fields * channel.declaration.max_rows;
    sample.available = true;
    std::copy(queue + 1, queue + h.queued, queue);
    --h.queued;
    queue[h.queued].slot = entry.slot;
    advance_to(entry.t);
    process_or_reject(entry.measurement, sample);
  }
}

void Engine::process_or_reject(int measurement, const SampleView& sample) {
  if (head().broken)
    conclude(measurement, sample.t, Outcome::rejected, broken_reason, 0, 0, false, nullptr);
  else
    process(measurement, sample);
}

void Engine::push_measurement(int measurement, const SampleView& sample) {
  auto& h = head();
  Ledger& ledger = *plan_.measurements[as_size(measurement)].ledger.in(arena_);
  if (h.broken) {
    ++ledger.offered;
    conclude(measurement, sample.t, Outcome::rejected, broken_reason, 0, 0, false, nullptr);
    return;
  }
  if (!h.started) {
    if (!plan_.initial.empty() || plan_.input_channel >= 0) {
      ++ledger.before_start;
      return;
    }
    start_blocks(sample.t);
    if (h.broken) return;
  }
  ++ledger.offered;
  if (sample.t < h.t) {
    conclude(measurement, sample.t, Outcome::late, "older than the filter's time", 0, 0, false, nullptr);
    return;
  }
  if (plan_.input_channel >= 0 && sample.t > h.input_end) {
    enqueue(measurement, sample);
    return;
  }
  advance_to(sample.t);
  process_or_reject(measurement, sample);
}

void Engine::finish() {
  auto& h = head();
  if (!h.started) return;
  if (!h.broken && h.pending > 0) step_pending(h.pending);
  const QueueEntry* queue = plan_.queue.in(arena_);
  for (int i = 0; i < h.queued; ++i)
    // Offered, but never reached by the input.
    conclude(queue[i].measurement, queue[i].t, h.broken ? Outcome::rejected : Outcome::unsupported,
             h.broken ? broken_reason : "no input up to its time", 0, 0, false, nullptr);
  h.queued = 0;
}

void Engine::write_estimates(SampleSlot& slot) {
  slot.t = head().t;
  slot.t0 = no_time;
  slot.rows = 0;
  double* out = slot.fields;
  for (const auto& block : plan_.blocks) {
    calling(block.type, "read");
    block.block->read(x() + block.stored_offset, out);
    out += block.declaration().outputs.size();
  }
  slot.has_covariance = true;
  const int ld = padded(plan_.n);
  for (int j = 0; j < plan_.n; ++j)
    for (int i = 0; i < plan_.n; ++i) slot.covariance[i + j * plan_.n] = P()[i + j * ld];
}

}  // namespace binnacle
