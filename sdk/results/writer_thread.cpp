// SPDX-License-Identifier: Apache-2.0
#include "results/writer_thread.hpp"

#include <utility>

#include "results/thread_without_signals.hpp"

namespace binnacle::results {

WriterThread::WriterThread(std::size_t most_waiting)
    : most_waiting_(most_waiting), thread_(thread_without_signals([this] { work(); })) {}

WriterThread::~WriterThread() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    tasks_.clear();
  }
  came_.notify_one();
  thread_.join();
}

void WriterThread::post(std::size_t bytes, std::function<void()> task) {
  {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [&] { return failure_ || bytes_ == 0 || bytes_ + bytes <= most_waiting_; });
    throw_failure();
    tasks_.push_back({bytes, std::move(task)});
    bytes_ += bytes;
  }
  came_.notify_one();
}

void WriterThread::finish() {
  std::unique_lock lock(mutex_);
  done_.wait(lock, [&] { return failure_ || (tasks_.empty() && is_idle_); });
  throw_failure();
}

void WriterThread::throw_failure() const {
  if (failure_) std::rethrow_exception(failure_);
}

void WriterThread::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    came_.wait(lock, [&] { return is_over_ || !tasks_.empty(); });
    if (is_over_) return;
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    is_idle_ = false;
    lock.unlock();
    std::exception_ptr failure;
    try {
      task.action();
    } catch (...) {
      failure = std::current_exception();
    }
    task.action = nullptr;  // what it holds goes before it no longer counts
    lock.lock();
    is_idle_ = true;
    bytes_ -= task.bytes;
    if (failure) {
      failure_ = failure;
      tasks_.clear();
      bytes_ = 0;
    }
    done_.notify_all();
  }
}

}  // namespace binnacle::results
