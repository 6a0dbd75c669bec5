// SPDX-License-Identifier: Apache-2.0
// Threads beside a run, which the process's signals do not meet.
#pragma once

#include <csignal>
#include <thread>
#include <utility>

namespace binnacle::results {

/// Begins a thread that takes no signal: those are for the threads at work.
template <class Action>
std::thread thread_without_signals(Action&& action) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread(std::forward<Action>(action));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

}  // namespace binnacle::results
