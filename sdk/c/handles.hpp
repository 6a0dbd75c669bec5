// SPDX-License-Identifier: Apache-2.0
// Handles and ids as callers hold them, and what stands behind them.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "binnacle/session.hpp"
#include "error.hpp"

namespace binnacle::c {

/// Compositions that were loaded are numbered, so that an id of one is not taken for that of another.
struct LoadedComposition {
  static constexpr std::uint64_t kind = 0x6e6f69746973706d;
  static constexpr const char* noun = "composition";
  std::shared_ptr<const Composition> composition;
  std::uint64_t number = 0;
  std::string warnings, warnings_json;
};

/// How many numbers a sample on a channel has.
struct SampleShape {
  std::uint64_t fields = 0, row_fields = 0, max_rows = 0, covariance = 0;
};

struct OpenSession {
  static constexpr std::uint64_t kind = 0x6e6f697373657321;
  static constexpr const char* noun = "session";
  std::uint64_t number = 0;  // of its composition
  Session session;
  std::vector<SampleShape> shapes;  // by channel
  std::string text;                 // that was given last
};

/// What a handle points to. It is never given back to the system but used again, the one that was closed longest ago first:
/// so a handle that was closed is seen to be so, for as long as no later one took its place.
template <class Content>
struct Slot {
  static constexpr const char* noun = Content::noun;
  const std::uint64_t kind = Content::kind;
  std::atomic<Content*> content = nullptr;
  Slot* next = nullptr;  // that is free

  std::unique_ptr<Content> take_content() { return std::unique_ptr<Content>(content.exchange(nullptr)); }
};

template <class Content>
class Slots {
 public:
  Slot<Content>& take(std::unique_ptr<Content> content) {
    const std::lock_guard lock(mutex_);
    Slot<Content>* slot = first_;
    if (slot)
      first_ = slot->next;
    else
      slot = &all_.emplace_back();
    if (!first_) last_ = nullptr;
    slot->next = nullptr;
    slot->content = content.release();
    return *slot;
  }
  void give_back(Slot<Content>& slot) {
    const std::lock_guard lock(mutex_);
    (last_ ? last_->next : first_) = &slot;
    last_ = &slot;
  }

 private:
  std::mutex mutex_;
  std::deque<Slot<Content>> all_;
  Slot<Content>*first_ = nullptr, *last_ = nullptr;
};

// What a caller sees of a slot is an address.
inline Slot<LoadedComposition>* slot_of(binnacle_composition* handle) {
  return reinterpret_cast<Slot<LoadedComposition>*>(handle);
}
inline const Slot<LoadedComposition>* slot_of(const binnacle_composition* handle) {
  return reinterpret_cast<const Slot<LoadedComposition>*>(handle);
}
inline Slot<OpenSession>* slot_of(binnacle_session* handle) { return reinterpret_cast<Slot<OpenSession>*>(handle); }
inline const Slot<OpenSession>* slot_of(const binnacle_session* handle) {
  return reinterpret_cast<const Slot<OpenSession>*>(handle);
}

/// Lives to the end of the process, since a thread may still use its session then.
template <class Content>
Slots<Content>& slots() {
  static auto& all = *new Slots<Content>;
  return all;
}
template <class Content>
Slots<Content>& slots_for(const Slot<Content>&) {
  return slots<Content>();
}

template <class Content>
void check_kind(const Slot<Content>* handle) {
  if (not_null(handle, Content::noun).kind != Content::kind)
    throw UsageError(std::string("this is no handle of a ") + Content::noun);
}

/// What stands behind a handle that is open.
auto& content_of(auto* handle) {
  const auto* const slot = slot_of(handle);
  check_kind(slot);
  auto* const content = slot->content.load(std::memory_order_acquire);
  if (!content) throw UsageError(std::string("the ") + slot->noun + " was closed");
  return *content;
}

void close(auto* handle) {
  if (!handle) return;
  auto* const slot = slot_of(handle);
  check_kind(slot);
  const std::unique_ptr content = slot->take_content();
  if (!content) throw UsageError(std::string("the ") + slot->noun + " was closed before");
  slots_for(*slot).give_back(*slot);
}

// ---- ids: number of the composition (24 bits), kind (4), filter (16), index (20)

enum class IdKind : std::uint64_t { channel = 1, filter, block, measurement };

binnacle_id id_of(std::uint64_t number, IdKind kind, int filter, int index);

/// Each throws UsageError for an id of another kind or of another composition.
ChannelId channel_of(std::uint64_t number, binnacle_id id);
FilterId filter_of(std::uint64_t number, binnacle_id id);
BlockId block_of(std::uint64_t number, binnacle_id id);
MeasurementId measurement_of(std::uint64_t number, binnacle_id id);

}  // namespace binnacle::c
