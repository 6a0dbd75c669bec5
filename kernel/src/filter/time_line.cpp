// SPDX-License-Identifier: Apache-2.0
#include "filter/time_line.hpp"

#include <algorithm>
#include <utility>

#include "filter/model_calls.hpp"

namespace binnacle::internal::filter {

TimeLine::TimeLine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena, Work& work)
    : plan_(plan),
      channels_(channels),
      work_(work),
      head_(*plan.head.in(arena)),
      pending_(plan.pending.in(arena)),
      pending_fields_(plan.pending_fields.in(arena)),
      last_input_(plan.last_input.in(arena)),
      driving_rates_(plan.driving_rates.in(arena)),
      queue_(plan.queue.in(arena)),
      queue_data_(plan.queue_data.in(arena)),
      samples_(as_size(plan.samples_per_step)),
      sample_fields_(as_size(plan.samples_per_step) * as_size(std::max(1, plan.input_fields))) {
  for (int field = 0; field < plan.input_fields; ++field)
    if (plan.input_used[as_size(field)]) used_fields_.push_back(field);
}

void TimeLine::reset() {
  head_ = TimeHead{};
  std::fill_n(last_input_, plan_.input_fields, 0.0);
  for (std::size_t i = 0; i < plan_.queue.count; ++i) queue_[i] = {{}, 0, static_cast<std::int32_t>(i)};
}

void TimeLine::start(Time t) {
  if (head_.starts++ == 0) head_.start = t;
  if (head_.starts == 2) head_.first_restart = t;
  head_.t = head_.last_start = head_.input_end = t;
  head_.started = 1;
  head_.just_started = 1;
  head_.restart_until = no_time;
  head_.pending = head_.driving_rates_known = 0;
  head_.bridged = 0;
}

bool TimeLine::is_complete(const SampleView& sample) const {
  double sum = 0;  // of zeros, where all are finite
  for (const int field : used_fields_) sum += sample.fields[field] * 0.0;
  return sum == 0.0;
}

/// A sensor that hangs repeats its numbers; one that works is noisy.
void TimeLine::watch_repeats(const SampleView& sample) {
  constexpr std::int64_t least = 20;  // fewer may be chance, or a logger that is faster than its sensor
  const std::span now(sample.fields, as_size(plan_.input_fields));
  const bool stands_still = std::ranges::all_of(now, [](double value) { return value == 0.0; });  // wheels do
  const bool repeats = !stands_still && std::ranges::equal(now, std::span(last_input_, now.size()));
  std::copy_n(sample.fields, plan_.input_fields, last_input_);
  if (!repeats) {
    ++head_.changes;
    head_.repeats = 0;
    return;
  }
  if (head_.repeats++ == 0) head_.repeats_since = sample.t;
  const Time length = sample.t - head_.repeats_since;
  if (head_.changes < least || head_.repeats < least || length <= head_.longest_repeat) return;
  head_.longest_repeat = length;
  head_.longest_repeat_at = head_.repeats_since;
}

void TimeLine::input(const SampleView& sample) {
  if (!is_complete(sample)) {
    ++head_.gaps;
    see(sample.t);  // the input has ended where nothing complete follows
    return;
  }
  watch_repeats(sample);
  const bool has_interval = sample.t0 != no_time;
  if (!head_.started) {
    if (!plan_.initial.empty()) return;
    work_.start(has_interval ? sample.t0 : sample.t);
    if (!has_interval) return;
  }
  if (sample.t <= head_.input_end) {
    if (sample.t < head_.input_end) ++head_.gaps;
    return;
  }
  const Time t0 = has_interval ? sample.t0 : head_.input_end;
  const double dt = seconds(sample.t - t0);
  if (head_.just_started && t0 < head_.input_end) {
    add_pending(head_.input_end, sample.t, t0, dt, sample.fields);
  } else {
    // A whole sample missing: the rates are held over the hole, and it is counted.
    if (!has_interval || t0 - head_.input_end >= sample.t - t0) {
      if (!head_.just_started || t0 > head_.input_end) ++head_.gaps;
      if (!bridge(has_interval ? t0 : sample.t, sample)) return;
    }
    if (is_stepped_at_once(sample.t)) return step_whole(sample, dt);
    if (sample.t > head_.input_end) add_pending(head_.input_end, sample.t, head_.input_end, dt, sample.fields);
  }
  head_.just_started = 0;
  drain_queue(sample.t);
  if (head_.pending >= plan_.samples_per_step) step_pending(head_.pending);
}

/// Of a sample that nothing waits for: no others of its group, and no measurement in its interval.
bool TimeLine::is_stepped_at_once(Time t) const {
  return plan_.samples_per_step == 1 && head_.pending == 0 && t > head_.input_end &&
         (head_.queued == 0 || queue_[0].sample.t > t);
}

/// The same as through the pending ones, without copies.
void TimeLine::step_whole(const SampleView& sample, double dt) {
  const Time t0 = std::exchange(head_.input_end, sample.t);
  head_.just_started = 0;
  samples_[0] = {t0, sample.t, dt, t0, sample.t, sample.fields, false};
  step(sample.t, 1);
}

/// The bridge is no sample of the sensor: it is stepped alone, never in a group with its neighbours. False where the hole
/// is too long: the filter stops at its begin.
bool TimeLine::bridge(Time until, const SampleView& sample) {
  if (head_.pending > 0) step_pending(head_.pending);
  const bool rates_only = std::ranges::find(plan_.input_kinds, FieldKind::increment) == plan_.input_kinds.end();
  const double hole = seconds(until - head_.input_end);
  if (plan_.longest_bridge > 0 && until - head_.input_end > plan_.longest_bridge) {
    head_.started = 0;
    head_.stopped_by = until - head_.input_end;
    head_.stopped_at = head_.input_end;
    flush(Outcome::unsupported, "in a hole of the input that is too long to bridge");
    return false;
  }
  if (until - head_.input_end > head_.longest_hole) {
    head_.longest_hole = until - head_.input_end;
    head_.longest_hole_at = head_.input_end;
  }
  if (!rates_only && !head_.driving_rates_known)
    throw Stop("the first input sample after the start has no interval, so its increments have no rate");
  for (int i = 0; i < plan_.input_fields && !rates_only; ++i)
    sample_fields_[as_size(i)] = driving_rates_[i] * (is_increment(i) ? hole : 1.0);
  add_pending(head_.input_end, until, head_.input_end, hole, rates_only ? sample.fields : sample_fields_.data(), true);
  drain_queue(until);
  if (head_.pending > 0) step_pending(head_.pending);
  return true;
}

void TimeLine::add_pending(Time t0, Time t1, Time whole_t0, double whole_dt, const double* fields, bool bridges) {
  // Room is for samples_per_step whole samples; what is older is stepped first.
  if (head_.pending == static_cast<int>(plan_.pending.count)) step_pending(head_.pending);
  pending_[head_.pending] = PendingInput{t0, t1, whole_t0, t1, whole_dt, bridges};
  std::copy_n(fields, plan_.input_fields, pending_fields_ + head_.pending * plan_.input_fields);
  ++head_.pending;
  head_.input_end = t1;
}

void TimeLine::offer(int measurement, const SampleView& sample) {
  see(sample.t);
  if (sample.t < head_.t) {
    work_.refuse(Outcome::late, "older than the filter's time");
  } else if (plan_.input_channel >= 0 && sample.t > head_.input_end) {
    enqueue(measurement, sample);
  } else {
    advance_to(sample.t);
    work_.measure(measurement, sample);
  }
}

void TimeLine::advance_to(Time t) {
  if (plan_.input_channel < 0) {
    if (t > head_.t) step(t, 0);
    return;
  }
  int whole = 0;
  while (whole < head_.pending && pending_[whole].t1 <= t) ++whole;
  if (whole > 0) step_pending(whole);
  if (head_.pending == 0 || pending_[0].t0 >= t) return;
  cut(0, t, sample_fields_.data(), samples_[0]);
  pending_[0].t0 = t;
  step(t, 1);
}

void TimeLine::end_input() {
  if (head_.pending > 0) step_pending(head_.pending);
}

// ---- the queue of samples ahead of the input

void TimeLine::enqueue(int measurement, const SampleView& sample) {
  if (as_size(head_.queued) == plan_.queue.count) {
    work_.refuse(Outcome::rejected, "the queue of samples ahead of the input is full");
    return;
  }
  QueueEntry* const end = queue_ + head_.queued++;
  const std::int32_t slot = end->slot;  // slots are a permutation kept behind the entries in use
  QueueEntry* const at = std::find_if(queue_, end, [&](const QueueEntry& other) {
    return std::pair(sample.t, measurement) < std::pair(other.sample.t, other.measurement);
  });
  std::copy_backward(at, end, end + 1);
  *at = {pack(channel_of(measurement), sample, queued_data(slot)), measurement, slot};
  work_.wait();
}

/// The first of the queue, which leaves it.
QueueEntry TimeLine::take() {
  const QueueEntry entry = queue_[0];
  std::copy(queue_ + 1, queue_ + head_.queued, queue_);
  --head_.queued;
  queue_[head_.queued].slot = entry.slot;
  work_.resume(entry.measurement, entry.sample.t);
  return entry;
}

void TimeLine::drain_queue(Time until) {
  while (head_.queued > 0 && queue_[0].sample.t <= until) {
    const auto [sample, measurement, slot] = take();
    advance_to(sample.t);
    work_.measure(measurement, unpack(channel_of(measurement), sample, queued_data(slot)));
  }
}

void TimeLine::flush(Outcome outcome, const char* reason) {
  while (head_.queued > 0) {
    take();
    work_.refuse(outcome, reason);
  }
}

// ---- steps

/// The part of a pending sample up to t1: increments in proportion of time, rates as they are.
void TimeLine::cut(int index, Time t1, double* raw, InputSample& sample) const {
  const PendingInput& pending = pending_[index];
  const bool is_whole = pending.t0 == pending.whole_t0 && t1 == pending.whole_t1;
  const double fraction = is_whole ? 1.0 : seconds(t1 - pending.t0) / seconds(pending.whole_t1 - pending.whole_t0);
  for (int f = 0; f < plan_.input_fields; ++f)
    raw[f] = pending_fields_[index * plan_.input_fields + f] * (is_increment(f) ? fraction : 1.0);
  sample.t0 = pending.t0;
  sample.t1 = t1;
  sample.dt = pending.whole_dt * fraction;
  sample.whole_t0 = pending.whole_t0;
  sample.whole_t1 = pending.whole_t1;
  sample.fields = raw;
  sample.bridges = pending.bridges != 0;
}

void TimeLine::step_pending(int whole) {
  const int width = plan_.input_fields;
  const auto is_fragment = [&](int i) { return pending_[i].t0 != pending_[i].whole_t0; };
  for (int done = 0; done < whole;) {
    int group = 1;
    if (!is_fragment(done))
      while (done + group < whole && group < plan_.samples_per_step && !is_fragment(done + group)) ++group;
    for (int i = 0; i < group; ++i)
      cut(done + i, pending_[done + i].t1, sample_fields_.data() + i * width, samples_[as_size(i)]);
    step(pending_[done + group - 1].t1, group);
    done += group;
  }
  std::copy(pending_ + whole, pending_ + head_.pending, pending_);
  std::copy(pending_fields_ + whole * width, pending_fields_ + head_.pending * width, pending_fields_);
  head_.pending -= whole;
}

void TimeLine::step(Time t1, int samples) {
  work_.step(t1, {samples_.data(), as_size(samples)});
  head_.t = t1;
  ++head_.steps;
  if (const InputSample* last = samples_.data() + samples - 1; samples > 0 && last->dt > 0) {
    for (int f = 0; f < plan_.input_fields; ++f)
      driving_rates_[f] = is_increment(f) ? last->fields[f] / last->dt : last->fields[f];
    head_.driving_rates_known = 1;
    head_.bridged = last->bridges;
  }
  work_.stepped();
}

}  // namespace binnacle::internal::filter
