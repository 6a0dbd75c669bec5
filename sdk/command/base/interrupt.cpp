// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <atomic>
#include <csignal>
#include <thread>

#include <semaphore.h>
#include <unistd.h>

#include "binnacle/plugin_call.hpp"
#include "sentinel.hpp"

namespace binnacle::command {

namespace {

constexpr std::chrono::milliseconds timeout{1500};

enum class Watch { off, on, barking };

/// A handler can reach nothing but a global.
std::atomic<int> noted{0};
std::atomic<bool> is_second_watched{false}, is_noted_twice{false};
std::atomic<Watch> watch{Watch::off};
sem_t came;
static_assert(std::atomic<int>::is_always_lock_free);

std::string calls() {
  std::string text;
  for (const auto& call : plugin_calls_under_way()) text += (text.empty() ? "" : "; ") + call;
  return text.empty() ? "no plugin call is under way" : "under way: " + text;
}

/// Waits for the first signal, then for the run to stop.
void guard(const std::string& left) {
  while (sem_wait(&came) != 0) {
  }
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (std::chrono::steady_clock::now() < end || (is_second_watched && watch != Watch::on)) {
    if (is_noted_twice) abandon("interrupted twice; " + calls() + "; " + left);
    if (watch != Watch::on && !is_second_watched) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  Watch expected = Watch::on;
  if (!watch.compare_exchange_strong(expected, Watch::barking)) return;
  abandon("interrupted, but the run does not stop; " + calls() + "; " + left);
}

/// It takes no signal, so that these find the threads at work as if it were not there.
void start_watchdog(const std::string& left) {
  sem_init(&came, 0, 0);
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread(guard, left).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace

void watch_signals(const std::string& left) {
  watch = Watch::on;
  start_watchdog(left);
  struct sigaction action = {};
  action.sa_handler = [](int signal) {
    noted = signal;
    sem_post(&came);
  };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

void watch_second_signal() {
  is_second_watched = true;
  struct sigaction action = {};
  action.sa_handler = [](int signal) {
    if (noted != 0) is_noted_twice = true;
    noted = signal;
    sem_post(&came);
  };
  action.sa_flags = static_cast<int>(SA_RESTART);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

void stand_down() {
  Watch expected = Watch::on;
  watch.compare_exchange_strong(expected, Watch::off);
  while (watch == Watch::barking) ::pause();  // the process is about to end
}

int interrupted_by() { return noted; }

void die_of_signal() {
  std::signal(noted, SIG_DFL);
  std::raise(noted);
}

}  // namespace binnacle::command
