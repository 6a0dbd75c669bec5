// SPDX-License-Identifier: Apache-2.0
// A slot for every thread that calls plugins. Slots are never destroyed: exit() ends a thread's own objects first, and
// its handlers want to read them.
#include <algorithm>
#include <cstdio>
#include <deque>
#include <mutex>
#include <string_view>

#include "binnacle/plugin_call.hpp"

namespace binnacle {

namespace {

struct Slot {
  std::atomic<const CallSite*> site{nullptr};
  bool is_taken = false;
};

struct Slots {
  std::mutex mutex;
  std::deque<Slot> all;  // a deque: a slot never moves
};

Slots& slots() {
  static Slots& kept = *new Slots;
  return kept;
}

thread_local Slot* own_slot = nullptr;

/// Gives the slot back when the thread ends; not when it ends inside a plugin call, which is exit().
struct GiveBack {
  ~GiveBack() {
    if (own_slot->site.load(std::memory_order_relaxed)) return;
    const std::lock_guard lock(slots().mutex);
    own_slot->is_taken = false;
    own_slot = nullptr;
  }
};

Slot& slot_of_this_thread() {
  if (own_slot) return *own_slot;
  const std::lock_guard lock(slots().mutex);
  auto& all = slots().all;
  const auto free = std::find_if(all.begin(), all.end(), [](const Slot& slot) { return !slot.is_taken; });
  own_slot = free != all.end() ? &*free : &all.emplace_back();
  own_slot->is_taken = true;
  static thread_local GiveBack at_end;
  return *own_slot;
}

std::string text_of(const Slot& slot) {
  const CallSite* site = slot.site.load(std::memory_order_acquire);
  return site ? site->text() : "";
}

}  // namespace

std::string CallSite::text() const {
  const char* const call = call_.load(std::memory_order_acquire);
  const std::string* const component = component_.load(std::memory_order_relaxed);
  if (!call || !component) return "";
  std::string_view plugin, type = *component;
  if (const std::string* const name = plugin_.load(std::memory_order_relaxed)) {
    plugin = *name;
  } else if (const auto slash = type.find('/'); slash != std::string_view::npos) {
    plugin = type.substr(0, slash);
    type.remove_prefix(slash + 1);
  }
  std::string text = "plugin '" + std::string(plugin) + "'";
  if (!type.empty()) text += ", component '" + std::string(type) + "'";
  text += std::string(": ") + call;
  const Time t = t_.load(std::memory_order_relaxed);
  if (t != no_time) {
    char at[48];
    std::snprintf(at, sizeof at, " at %.9g s", seconds(t));
    text += at;
  }
  return text;
}

CallScope::CallScope(const CallSite& site) noexcept {
  auto& own = slot_of_this_thread().site;  // no other thread writes it
  previous_ = own.load(std::memory_order_relaxed);
  own.store(&site, std::memory_order_release);
}

CallScope::~CallScope() { own_slot->site.store(previous_, std::memory_order_release); }

std::string plugin_call_under_way() { return own_slot ? text_of(*own_slot) : ""; }

std::vector<std::string> plugin_calls_under_way() {
  std::vector<std::string> texts;
  const std::lock_guard lock(slots().mutex);
  for (const auto& slot : slots().all)
    if (std::string text = text_of(slot); !text.empty()) texts.push_back(std::move(text));
  return texts;
}

}  // namespace binnacle
