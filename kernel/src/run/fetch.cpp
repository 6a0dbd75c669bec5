// SPDX-License-Identifier: Apache-2.0
// The next sample of a source: its own, or one that was made for several runtimes.
#include "base/time_range.hpp"
#include "run/runtime.hpp"
#include "run/shared_feed.hpp"

namespace binnacle::internal::runtime {

SourceStatus Runtime::ask(std::size_t index, const char* call, SourceOutput& out) {
  const auto& source = plan_.sources[index];
  for (auto& slot : source_slots_[index]) slot.clear();
  return guard_call<DataError>(plan_, source, call, source.head.in(arena())->sample.t,
                               [&] { return source.object->next(source.memory.in(arena()), out); });
}

/// The same of what several runtimes have in common.
SourceStatus Runtime::ask_shared(std::size_t index, const char* call, Tap& tap, SourceOutput& out) {
  const SharedStream& stream = *tap.stream;
  ++taps_->taken;
  const std::size_t place = tap.place++;
  if (!stream.has(place)) return make_shared(index, call, *tap.stream, out);
  const SharedStream::Item& item = stream.at(place);
  if (item.channel >= 0 && as_size(item.channel) < source_slots_[index].size())
    stream.copy(place, out.on(OutputChannel(item.channel)));
  return item.status;
}

/// The stream's next item.
SourceStatus Runtime::make_shared(std::size_t index, const char* call, SharedStream& stream, SourceOutput& out) {
  const auto& source = plan_.sources[index];
  auto& slots = source_slots_[index];
  for (auto& slot : slots) slot.clear();
  const SourceStatus status = guard_call<DataError>(plan_, source, call, source.head.in(arena())->sample.t, [&] {
    return stream.make([&] { return source.object->next(stream.memory(), out); });
  });
  const int channel = out.channel();
  const bool is_own = channel >= 0 && as_size(channel) < slots.size();
  stream.add({SharedStream::Item::Kind::answered, status, channel}, is_own ? &slots[as_size(channel)] : nullptr);
  return status;
}

void Runtime::fetch(std::size_t index) {
  const auto& source = plan_.sources[index];
  SourceHead& head = *source.head.in(arena());
  auto& slots = source_slots_[index];
  SourceOutput out(slots.data());
  const Time previous = head.sample.t;
  const char* const call = previous == no_time ? "next for its first sample" : "next";
  const SourceStatus status = taps_ ? ask_shared(index, call, taps_->sources[index], out) : ask(index, call, out);
  const int channel = out.channel();
  const auto fault = [&](const char* code, const std::string& what) {
    return DataError(
        Diagnostic{Severity::error, code, plan_.document.origin(source.pointer), source.pointer,
                   "source '" + source.name + "' " + what + " (" + call_text(*source.type, call, previous) + ")"});
  };
  if (status == SourceStatus::error) throw fault("B061", "cannot continue");
  if (status == SourceStatus::wait) return;  // asked again at the next instant
  if (status != SourceStatus::sample) {
    head.status = 2;
    return;
  }
  const bool is_own = channel >= 0 && as_size(channel) < slots.size();
  static constexpr SampleWriter of_no_channel{};
  const SampleWriter& slot = is_own ? slots[as_size(channel)] : of_no_channel;
  if (slot.t == no_time || slot.rows < 0 || slot.rows > slot.max_rows)
    throw fault("B045", "emitted a sample that it did not declare");
  if (!base::is_near(slot.t) || (slot.t0 != no_time && !base::is_near(slot.t0)))
    throw fault("B062",
                "emitted a sample at " + time_text(slot.t) + ", more than " + base::farthest_text + " from zero");
  if (previous != no_time && slot.t < previous && !source.object->declaration().live)
    throw fault("B063", "goes back in time, to " + time_text(slot.t));
  head = SourceHead{{slot.t, slot.t0, slot.rows, slot.has_covariance}, 1, channel};
}

}  // namespace binnacle::internal::runtime
