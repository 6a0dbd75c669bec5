// SPDX-License-Identifier: Apache-2.0
#include "filter/time_line.hpp"

#include <algorithm>
#include <cmath>

#include "filter/fields.hpp"
#include "filter/model_calls.hpp"

namespace binnacle::filter {

TimeLine::TimeLine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena, Work& work)
    : plan_(plan),
      channels_(channels),
      arena_(arena),
      work_(work),
      samples_(as_size(plan.samples_per_step)),
      sample_fields_(as_size(plan.samples_per_step) * as_size(std::max(1, plan.input_fields))) {}

void TimeLine::reset() {
  head() = TimeHead{};
  for (std::int32_t i = 0; i < plan_.queue_capacity; ++i) {
    plan_.queue.in(arena_)[i] = QueueEntry{};
    plan_.queue.in(arena_)[i].slot = i;
  }
}

void TimeLine::start(Time t) {
  auto& h = head();
  h.t = h.start = h.input_end = t;
  h.started = 1;
  h.just_started = 1;
}

bool TimeLine::is_complete(const SampleView& sample) const {
  for (int i = 0; i < plan_.input_fields; ++i)
    if (plan_.input_used[as_size(i)] && !std::isfinite(sample.fields[i])) return false;
  return true;
}

void TimeLine::input(const SampleView& sample) {
  auto& h = head();
  if (!is_complete(sample)) {
    ++h.gaps;
    return;
  }
  const bool has_interval = sample.t0 != no_time;
  if (!h.started) {
    if (!plan_.initial.empty()) return;
    work_.start(has_interval ? sample.t0 : sample.t);
    if (!has_interval) return;
  }
  if (sample.t <= h.input_end) {
    if (sample.t < h.input_end) ++h.gaps;
    return;
  }
  const Time t0 = has_interval ? sample.t0 : h.input_end;
  const double dt = seconds(sample.t - t0);
  if (h.just_started && t0 < h.input_end) {
    add_pending(h.input_end, sample.t, t0, dt, sample.fields);
  } else {
    // A whole sample missing: the rates are held over the hole, and it is counted.
    if (!has_interval || t0 - h.input_end >= sample.t - t0) {
      if (!h.just_started || t0 > h.input_end) ++h.gaps;
      bridge(has_interval ? t0 : sample.t, sample);
    }
    if (sample.t > h.input_end) add_pending(h.input_end, sample.t, h.input_end, dt, sample.fields);
  }
  h.just_started = 0;
  drain_queue(sample.t);
  if (h.pending >= plan_.samples_per_step) step_pending(h.pending);
}

/// The bridge is no sample of the sensor: it is stepped alone, never in a group with its neighbours.
void TimeLine::bridge(Time until, const SampleView& sample) {
  auto& h = head();
  if (h.pending > 0) step_pending(h.pending);
  bool rates_only = true;
  for (int i = 0; i < plan_.input_fields; ++i)
    rates_only = rates_only && plan_.input_kinds[as_size(i)] != FieldKind::increment;
  const double hole = seconds(until - h.input_end);
  if (!rates_only && !h.driving_rates_known)
    throw Stop("the first input sample after the start has no interval, so its increments have no rate");
  for (int i = 0; i < plan_.input_fields && !rates_only; ++i)
    sample_fields_[as_size(i)] =
        plan_.driving_rates.in(arena_)[i] * (plan_.input_kinds[as_size(i)] == FieldKind::increment ? hole : 1.0);
  add_pending(h.input_end, until, h.input_end, hole, rates_only ? sample.fields : sample_fields_.data(), true);
  drain_queue(until);
  if (h.pending > 0) step_pending(h.pending);
}

void TimeLine::add_pending(Time t0, Time t1, Time whole_t0, double whole_dt, const double* fields, bool bridges) {
  auto& h = head();
  // Room is for samples_per_step whole samples; what is older is stepped first.
  if (h.pending == static_cast<int>(plan_.pending.count)) step_pending(h.pending);
  plan_.pending.in(arena_)[h.pending] = PendingInput{t0, t1, whole_t0, t1, whole_dt, bridges};
  std::copy_n(fields, plan_.input_fields, plan_.pending_fields.in(arena_) + h.pending * plan_.input_fields);
  ++h.pending;
  h.input_end = t1;
}

void TimeLine::offer(int measurement, const SampleView& sample) {
  const auto& h = head();
  if (sample.t < h.t) {
    work_.refuse(Outcome::late, "older than the filter's time");
  } else if (plan_.input_channel >= 0 && sample.t > h.input_end) {
    enqueue(measurement, sample);
  } else {
    advance_to(sample.t);
    work_.measure(measurement, sample);
  }
}

void TimeLine::advance_to(Time t) {
  auto& h = head();
  if (plan_.input_channel < 0) {
    if (t > h.t) step(t, 0);
    return;
  }
  const PendingInput* pending = plan_.pending.in(arena_);
  int whole = 0;
  while (whole < h.pending && pending[whole].t1 <= t) ++whole;
  if (whole > 0) step_pending(whole);
  if (h.pending > 0 && pending[0].t0 < t) step_fragment(t);
}

void TimeLine::end_input() {
  if (head().pending > 0) step_pending(head().pending);
}

// ---- the queue of samples ahead of the input

void TimeLine::enqueue(int measurement, const SampleView& sample) {
  auto& h = head();
  QueueEntry* queue = plan_.queue.in(arena_);
  if (h.queued == plan_.queue_capacity) {
    work_.refuse(Outcome::rejected, "the queue of samples ahead of the input is full");
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
  pack(channels_[as_size(plan_.measurements[as_size(measurement)].channel)], sample,
       plan_.queue_data.in(arena_) + as_size(slot) * plan_.queue_doubles);
  work_.wait();
}

QueueEntry TimeLine::take() {
  auto& h = head();
  QueueEntry* queue = plan_.queue.in(arena_);
  const QueueEntry entry = queue[0];
  std::copy(queue + 1, queue + h.queued, queue);
  --h.queued;
  queue[h.queued].slot = entry.slot;
  work_.resume(entry.measurement, entry.t);
  return entry;
}

void TimeLine::drain_queue(Time until) {
  const QueueEntry* queue = plan_.queue.in(arena_);
  while (head().queued > 0 && queue[0].t <= until) {
    const QueueEntry entry = take();
    advance_to(entry.t);
    const auto& channel = channels_[as_size(plan_.measurements[as_size(entry.measurement)].channel)];
    const double* data = plan_.queue_data.in(arena_) + as_size(entry.slot) * plan_.queue_doubles;
    work_.measure(entry.measurement, unpack(channel, data, entry.t, entry.t0, entry.rows, entry.has_covariance != 0));
  }
}

void TimeLine::flush(Outcome outcome, const char* reason) {
  while (head().queued > 0) {
    take();
    work_.refuse(outcome, reason);
  }
}

// ---- steps

/// The part of an input sample up to t1: increments in proportion of time, rates as they are.
InputSample TimeLine::cut(const PendingInput& pending, Time t1, const double* fields, double* raw) const {
  const bool is_whole = pending.t0 == pending.whole_t0 && t1 == pending.whole_t1;
  const double fraction = is_whole ? 1.0 : seconds(t1 - pending.t0) / seconds(pending.whole_t1 - pending.whole_t0);
  for (int f = 0; f < plan_.input_fields; ++f)
    raw[f] = fields[f] * (plan_.input_kinds[as_size(f)] == FieldKind::increment ? fraction : 1.0);
  return {pending.t0, t1, pending.whole_dt * fraction, pending.whole_t0, pending.whole_t1, raw, pending.bridges != 0};
}

void TimeLine::step_pending(int whole) {
  auto& h = head();
  PendingInput* pending = plan_.pending.in(arena_);
  double* fields = plan_.pending_fields.in(arena_);
  const int width = plan_.input_fields;

  const auto is_fragment = [&](int i) { return pending[i].t0 != pending[i].whole_t0; };
  for (int done = 0; done < whole;) {
    int group = 1;
    if (!is_fragment(done))
      while (done + group < whole && group < plan_.samples_per_step && !is_fragment(done + group)) ++group;
    for (int i = 0; i < group; ++i)
      samples_[as_size(i)] =
          cut(pending[done + i], pending[done + i].t1, fields + (done + i) * width, sample_fields_.data() + i * width);
    step(pending[done + group - 1].t1, group);
    done += group;
  }
  std::copy(pending + whole, pending + h.pending, pending);
  std::copy(fields + whole * width, fields + h.pending * width, fields);
  h.pending -= whole;
}

void TimeLine::step_fragment(Time t1) {
  PendingInput& sample = plan_.pending.in(arena_)[0];
  samples_[0] = cut(sample, t1, plan_.pending_fields.in(arena_), sample_fields_.data());
  sample.t0 = t1;
  step(t1, 1);
}

void TimeLine::step(Time t1, int samples) {
  auto& h = head();
  work_.step(t1, {samples_.data(), as_size(samples)});
  h.t = t1;
  ++h.steps;
  if (samples > 0) remember_driving_rates(samples_[as_size(samples - 1)]);
  work_.stepped();
}

void TimeLine::remember_driving_rates(const InputSample& sample) {
  if (!(sample.dt > 0)) return;
  double* rates = plan_.driving_rates.in(arena_);
  for (int f = 0; f < plan_.input_fields; ++f)
    rates[f] = plan_.input_kinds[as_size(f)] == FieldKind::increment ? sample.fields[f] / sample.dt : sample.fields[f];
  head().driving_rates_known = 1;
  head().bridged = sample.bridges;
}

}  // namespace binnacle::filter
