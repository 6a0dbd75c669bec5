// SPDX-License-Identifier: Apache-2.0
#include "interrupt.hpp"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace binnacle::python {

namespace py = pybind11;

namespace {

struct Work {
  std::atomic<bool> goes_on{true};
  std::mutex mutex;
  std::condition_variable ended;
  bool is_over = false;
  std::exception_ptr failure;

  void carry_out(const std::function<void(const GoesOn&)>& work) {
    try {
      work([this] { return goes_on.load(std::memory_order_relaxed); });
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    is_over = true;
    ended.notify_one();
  }
  bool wait_for(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex);
    return ended.wait_for(lock, time, [this] { return is_over; });
  }
};

/// Leaves Python's error set.
bool has_signal() {
  const py::gil_scoped_acquire locked;
  return PyErr_CheckSignals() != 0;
}

}  // namespace

void interruptibly(const std::function<void(const GoesOn&)>& work) {
  Work state;
  bool is_interrupted = false;
  {
    const py::gil_scoped_release unlocked;
    std::thread thread([&] { state.carry_out(work); });
    while (!state.wait_for(std::chrono::milliseconds(50)))
      if (!is_interrupted && has_signal()) {
        is_interrupted = true;
        state.goes_on = false;
      }
    thread.join();
  }
  if (is_interrupted) throw py::error_already_set();
  if (state.failure) std::rethrow_exception(state.failure);
}

}  // namespace binnacle::python
