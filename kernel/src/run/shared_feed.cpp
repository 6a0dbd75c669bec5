// SPDX-License-Identifier: Apache-2.0
#include "run/shared_feed.hpp"

#include <utility>

#include "run/runtime.hpp"

namespace binnacle::internal::runtime {

// A slot's numbers lie in one piece: per-epoch fields, per-row fields, covariance.
void SharedStream::add(Item item, const SampleWriter* slot) {
  numbers_.resize(std::max(numbers_.size(), (items_.size() + 1) * width_));
  if (slot) {
    item.head = {slot->t, slot->t0, slot->rows, slot->has_covariance};
    std::copy_n(slot->fields, doubles_[as_size(item.channel)],
                numbers_.begin() + static_cast<std::ptrdiff_t>(items_.size() * width_));
  }
  items_.push_back(item);
}

void SharedStream::copy(std::size_t place, SampleWriter& slot) const {
  const Item& item = at(place);
  slot.t = item.head.t;
  slot.t0 = item.head.t0;
  slot.rows = item.head.rows;
  slot.has_covariance = item.head.has_covariance != 0;
  std::copy_n(numbers_.begin() + static_cast<std::ptrdiff_t>((place - first_) * width_),
              doubles_[as_size(item.channel)], slot.fields);
}

void SharedStream::forget(std::size_t place) {
  const auto count = static_cast<std::ptrdiff_t>(place - first_);
  if (count <= 0) return;
  const auto end = static_cast<std::ptrdiff_t>(items_.size());
  const auto width = static_cast<std::ptrdiff_t>(width_);
  std::move(numbers_.begin() + count * width, numbers_.begin() + end * width, numbers_.begin());
  items_.erase(items_.begin(), items_.begin() + count);
  first_ = place;
}

template <class Stage>
Tap SharedFeed::tap_of(Runtime& runtime, const Stage& stage) {
  if (stage.identity.empty()) return {};
  for (const auto& stream : streams_)
    if (stream->identity() == stage.identity) return {stream.get(), stream->begin()};
  return {streams_.emplace_back(std::make_unique<SharedStream>(runtime.plan(), stage, runtime.arena())).get(), 0};
}

Taps& SharedFeed::add(Runtime& runtime) {
  Taps& taps = *taps_.emplace_back(std::make_unique<Taps>());
  for (const auto& source : runtime.plan().sources) taps.sources.push_back(tap_of(runtime, source));
  // With history they work once more where a sample came late, and in another order on what arrives late.
  const bool is_in_order = !runtime.has_more_than_arena();
  for (const auto& transform : runtime.plan().transforms)
    taps.transforms.push_back(is_in_order ? tap_of(runtime, transform) : Tap{});
  return taps;
}

void SharedFeed::remove(const Taps& taps) {
  std::erase_if(taps_, [&](const auto& own) { return own.get() == &taps; });
}

void SharedFeed::forget_taken() {
  for (const auto& stream : streams_) {
    std::size_t first = stream->end();
    for (const auto& taps : taps_)
      for (const auto* list : {&taps->sources, &taps->transforms})
        for (const Tap& tap : *list)
          if (tap.stream == stream.get()) first = std::min(first, tap.place);
    stream->forget(first);
  }
}

}  // namespace binnacle::internal::runtime
