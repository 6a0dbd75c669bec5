// SPDX-License-Identifier: Apache-2.0
// WriterThread: files are written beside the run, and not by its thread.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace binnacle::results {

/// Carries out tasks one after the other, in the order in which they were posted. HDF5 is not made for two threads: all that
/// calls it goes through one.
class WriterThread {
 public:
  /// As much as may wait in tasks, unless a single one holds more.
  static constexpr std::size_t most_bytes = 8 << 20;

  explicit WriterThread(std::size_t most_waiting = most_bytes);
  /// What waits is dropped; the task under way ends first.
  ~WriterThread();
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  /// `bytes`: what the task holds. Waits where too much does. After a task has thrown none is carried out any more, and this
  /// and finish() throw what it threw.
  void post(std::size_t bytes, std::function<void()> task);
  /// Waits until all is done.
  void finish();

 private:
  struct Task {
    std::size_t bytes;
    std::function<void()> action;
  };

  void work();
  void throw_failure() const;

  const std::size_t most_waiting_;
  std::mutex mutex_;
  std::condition_variable came_, done_;
  std::deque<Task> tasks_;
  std::size_t bytes_ = 0;  // of those that wait, and of the one under way
  bool is_idle_ = true, is_over_ = false;
  std::exception_ptr failure_;
  std::thread thread_;  // the last: it uses the others
};

}  // namespace binnacle::results
