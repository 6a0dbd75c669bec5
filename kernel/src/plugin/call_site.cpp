// SPDX-License-Identifier: Apache-2.0
// Every thread that calls plugins has its site listed. What handlers of exit() want to read is never destroyed: it ends a
// thread's own objects first.
#include <cstdio>
#include <mutex>
#include <string_view>

#include "binnacle/plugin_call.hpp"

namespace binnacle {

namespace {

using ThreadSite = std::atomic<const CallSite*>;

struct Threads {
  std::mutex mutex;
  std::vector<const ThreadSite*> sites;
};

Threads& threads() {
  static Threads& kept = *new Threads;
  return kept;
}

thread_local ThreadSite own_site{nullptr};

/// Lists this thread's site until the thread ends; not when it ends inside a plugin call, which is exit().
struct Listed {
  Listed() {
    const std::lock_guard lock(threads().mutex);
    threads().sites.push_back(&own_site);
  }
  ~Listed() {
    if (own_site.load(std::memory_order_relaxed)) return;
    const std::lock_guard lock(threads().mutex);
    std::erase(threads().sites, &own_site);
  }
};

std::string text_at(const ThreadSite& thread) {
  const CallSite* site = thread.load(std::memory_order_acquire);
  return site ? site->text() : "";
}

}  // namespace

std::string CallSite::text(std::string_view pointer) const {
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
  if (!pointer.empty()) text += " (" + std::string(pointer) + ")";
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
  static thread_local const Listed listed;
  previous_ = own_site.load(std::memory_order_relaxed);  // no other thread writes it
  own_site.store(&site, std::memory_order_release);
}

CallScope::~CallScope() { own_site.store(previous_, std::memory_order_release); }

std::string plugin_call_under_way() { return text_at(own_site); }

std::vector<std::string> plugin_calls_under_way() {
  std::vector<std::string> texts;
  const std::lock_guard lock(threads().mutex);
  for (const ThreadSite* site : threads().sites)
    if (std::string text = text_at(*site); !text.empty()) texts.push_back(std::move(text));
  return texts;
}

std::string what_was_thrown() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "something that is not a std::exception";
  }
}

}  // namespace binnacle
