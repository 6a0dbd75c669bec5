// SPDX-License-Identifier: Apache-2.0
// Step observers written in Python.
#pragma once

#include <exception>
#include <string>

#include "record_fields.hpp"

namespace binnacle::python {

/// The first exception of any observer of a run. Nobody is called after it.
class Failure {
 public:
  bool is_there() const { return exception_ != nullptr; }
  void note(std::exception_ptr exception) {
    if (!exception_) exception_ = std::move(exception);
  }
  /// Throws it, if there is one.
  void raise() {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::exception_ptr exception_;
};

/// Calls those of started, restored, rewound, stepped, offered and inflated that the object has; or the object itself with
/// each step and each sample, where it has none of them. Takes the GIL for each call.
class PythonObserver final : public StepObserver {
 public:
  /// Holds the GIL, as its destructor does. Throws TypeError where nothing of the object can be called.
  PythonObserver(const std::string& filter, const py::object& observer, Sizes sizes, Failure& failure);

  Wants wants() const override { return wants_; }
  void started(Time t, const double* x, ConstMatrixView P) override { call_with_state(started_, t, x, P); }
  void restored(Time t, const double* x, ConstMatrixView P) override { call_with_state(restored_, t, x, P); }
  void rewound(Time t) override;
  void stepped(const StepRecord& record) override { call_with(stepped_, record); }
  void offered(const UpdateRecord& record) override { call_with(offered_, record); }
  void inflated(const InflationRecord& record) override { call_with(inflated_, record); }

 private:
  template <class Call>
  void guarded(const py::object& method, Call&& call);
  template <class Record>
  void call_with(const py::object& method, const Record& record);
  void call_with_state(const py::object& method, Time t, const double* x, ConstMatrixView P);

  py::object started_, restored_, rewound_, stepped_, offered_, inflated_;  // None: not called
  Sizes sizes_;
  Failure& failure_;
  Wants wants_ = Wants::everything;
};

void bind_observers(py::module_& module);

}  // namespace binnacle::python
