// SPDX-License-Identifier: Apache-2.0
// Ctrl-C in a run that holds no GIL.
#pragma once

#include <chrono>
#include <functional>

#include <pybind11/pybind11.h>

namespace binnacle::python {

/// Asks Python at most ten times a second whether a signal came; its handler's exception (KeyboardInterrupt) ends the run.
class SignalWatch {
 public:
  void operator()() {
    const auto now = std::chrono::steady_clock::now();
    if (now - asked_ < std::chrono::milliseconds(100)) return;
    asked_ = now;
    const pybind11::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }

 private:
  std::chrono::steady_clock::time_point asked_ = std::chrono::steady_clock::now();
};

/// Any thread may ask; false: stop soon.
using GoesOn = std::function<bool()>;

/// Does the work in a thread of its own, which may have threads as well and holds no GIL, while this one looks out for signals:
/// after one, `goes_on` says false, and once the work has ended the handler's exception (KeyboardInterrupt) is thrown.
/// Else what the work throws is. Called with the GIL, returns with it.
void interruptibly(const std::function<void(const GoesOn& goes_on)>& work);

}  // namespace binnacle::python
