// SPDX-License-Identifier: Apache-2.0
// Which plugin call each thread is in: for whoever has to name it from outside, a watchdog or a handler at exit.
#pragma once

#include <atomic>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle {

/// A place from which plugins are called. Its thread writes, any thread reads: plain stores on common processors.
class CallSite {
 public:
  /// `component`: "csv" of `plugin`, "" for a call into the plugin itself; "core/vector" where `plugin` is null. All are
  /// referred to, not copied.
  void enter(const std::string* plugin, const std::string& component, const char* call) noexcept {
    plugin_.store(plugin, std::memory_order_relaxed);
    component_.store(&component, std::memory_order_relaxed);
    call_.store(call, std::memory_order_release);
  }
  void leave() noexcept { call_.store(nullptr, std::memory_order_release); }
  /// The sample at work; no_time: none.
  void set_time(Time t) noexcept { t_.store(t, std::memory_order_relaxed); }

  /// As entered; the call is null when none is under way.
  const std::string* component() const noexcept { return component_.load(std::memory_order_relaxed); }
  const char* call() const noexcept { return call_.load(std::memory_order_acquire); }
  Time time() const noexcept { return t_.load(std::memory_order_relaxed); }

  /// "plugin 'csv', component 'csv' (/sources/imu): next at 12.3 s"; empty when no call is under way.
  std::string text(std::string_view pointer = "") const;

 private:
  std::atomic<const std::string*> plugin_{nullptr};
  std::atomic<const std::string*> component_{nullptr};
  std::atomic<const char*> call_{nullptr};
  std::atomic<Time> t_{no_time};
};

/// Makes a site this thread's until the scope ends; the one before it is back then.
class CallScope {
 public:
  explicit CallScope(const CallSite& site) noexcept;
  ~CallScope();
  CallScope(const CallScope&) = delete;
  CallScope& operator=(const CallScope&) = delete;

 private:
  const CallSite* previous_;
};

/// CallSite::text() of this thread, also from a handler at exit; empty when it is in no plugin call.
std::string plugin_call_under_way();
/// The same of every thread that is in one.
std::vector<std::string> plugin_calls_under_way();

/// Of the exception that is being handled; nothing of the plugin's is referred to.
std::string what_was_thrown();

/// Runs `call` as the plugin call that is under way (arguments as of CallSite). What escapes becomes what `error` makes of
/// "plugin 'csv', component 'csv': next at 12.3 s threw: …".
template <class Call, class Error>
auto call_plugin(const std::string* plugin, const std::string& component, const char* name, Time t, Call&& call,
                 Error&& error) {
  CallSite site;
  site.enter(plugin, component, name);
  site.set_time(t);
  const CallScope scope(site);
  try {
    return std::forward<Call>(call)();
  } catch (...) {
    throw std::forward<Error>(error)(site.text() + " threw: " + what_was_thrown());
  }
}

}  // namespace binnacle
