// SPDX-License-Identifier: Apache-2.0
// Every call of a filter into a plugin, each in one place. While one is under way its component is known, so that what it
// throws, or a number that may not be, is blamed on it by name.
#pragma once

#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "binnacle/plugin_call.hpp"
#include "filter/note_book.hpp"
#include "filter/plan.hpp"

namespace binnacle::filter {

/// A filter cannot go on: what() is its diagnosis.
struct Stop : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "12.3 s"
inline std::string time_text(Time t) {
  char text[48];
  std::snprintf(text, sizeof text, "%.9g s", seconds(t));
  return text;
}
/// "plugin 'core', component 'vector' (/filters/f/blocks/x): plus at 12.3 s"
inline std::string call_text(const std::string& type, const std::string& pointer, const char* call, Time t) {
  const auto slash = type.find('/');
  const std::string component = slash == std::string::npos ? type : type.substr(slash + 1);
  return "plugin '" + type.substr(0, slash) + "', component '" + component + "' (" + pointer + "): " + call +
         (t == no_time ? "" : " at " + time_text(t));
}

class ModelCalls {
 public:
  explicit ModelCalls(std::byte* arena) : arena_(arena) {}

  /// The time of the sample or step at work; no_time: none yet.
  void set_time(Time t) { site_.set_time(t); }
  Time time() const { return site_.time(); }
  bool is_under_way() const { return site_.call() != nullptr; }
  /// call_text() of the call under way.
  std::string text() const { return call_text(*site_.component(), *pointer_, site_.call(), time()); }
  /// Forgets a call that threw.
  void leave() { site_.leave(); }
  /// The call under way, for other threads and for a handler at exit.
  const CallSite& site() const { return site_; }
  /// What models noted.
  NoteBook& note_book() { return note_book_; }
  const NoteBook& note_book() const { return note_book_; }

  /// Of a process model or a part of a measurement.
  template <class Plan>
  void start(const Plan& plan) {
    during(plan.type, plan.pointer, "start", [&] { plan.model->start(plan.memory.in(arena_)); });
  }
  void start_noise(const MeasurementPlan& plan) {
    during(plan.noise_type, plan.pointer, "start", [&] { plan.noise->start(memory_of(plan.noise_memory)); });
  }

  void plus(const BlockPlan& plan, const double* x, const double* delta, double* result) {
    during(plan.type, plan.pointer, "plus", [&] {
      const auto& d = plan.declaration();
      plan.block->plus({x, d.stored_size}, {delta, d.dof()}, {result, d.stored_size});
    });
  }
  void minus(const BlockPlan& plan, const double* y, const double* x, double* delta) {
    during(plan.type, plan.pointer, "minus", [&] {
      const auto& d = plan.declaration();
      plan.block->minus({y, d.stored_size}, {x, d.stored_size}, {delta, d.dof()});
    });
  }
  void read(const BlockPlan& plan, const double* x, double* outputs) {
    during(plan.type, plan.pointer, "read", [&] {
      plan.block->read({x, plan.declaration().stored_size}, {outputs, plan.outputs()});
    });
  }
  Result write(const BlockPlan& plan, const double* outputs, double* x) {
    return during(plan.type, plan.pointer, "write", [&] {
      return plan.block->write({outputs, plan.outputs()}, {x, plan.declaration().stored_size});
    });
  }
  bool reset_jacobian(const BlockPlan& plan, const double* x, const double* delta, double* G) {
    return during(plan.type, plan.pointer, "reset_jacobian", [&] {
      const int dof = plan.dof();
      return plan.block->reset_jacobian({x, plan.declaration().stored_size}, {delta, dof}, {G, dof, dof, dof});
    });
  }

  Result evaluate(const DerivedPlan& plan, const double* const* x, const Driving& u, DerivedOutput& out) {
    const DerivedInput in{x, u, notes()};
    return during(plan.type, plan.pointer, "evaluate", [&] { return plan.derived->evaluate(in, out); });
  }
  Result propagate(const ProcessPlan& plan, const Step& step, const double* const* x, const SampleView* auxiliary,
                   ProcessOutput& out) {
    const ProcessInput in{step, x, auxiliary, memory_of(plan.memory), notes()};
    return during(plan.type, plan.pointer, "propagate", [&] { return plan.model->propagate(in, out); });
  }
  void linearized(const ProcessPlan& plan, const double* const* x, const SampleView* auxiliary, ContinuousOutput& out) {
    const ContinuousInput in{x, auxiliary, notes()};
    during(plan.type, plan.pointer, "linearized", [&] { plan.model->linearized(in, out); });
  }
  Result linearize(const PartPlan& plan, const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const Driving& u, const PortCovariance& P, MeasurementOutput& out) {
    const MeasurementInput in{sample, auxiliary, x, u, memory_of(plan.memory), P, notes()};
    return during(plan.type, plan.pointer, "linearize", [&] { return plan.model->linearize(in, out); });
  }
  void estimate(const MeasurementPlan& plan, Innovation& innovation, MatrixView R) {
    innovation.memory = memory_of(plan.noise_memory);
    during(plan.noise_type, plan.pointer, "estimate", [&] { plan.noise->estimate(innovation, R); });
  }
  void after(const MeasurementPlan& plan, ConstVectorView residual, ConstMatrixView HPHt) {
    const AfterUpdate in{Outcome::accepted, residual, HPHt, memory_of(plan.noise_memory)};
    during(plan.noise_type, plan.pointer, "after", [&] { plan.noise->after(in); });
  }

 private:
  /// A call that returns is over; one that throws stays, to be named.
  template <class Call>
  std::invoke_result_t<Call&> during(const std::string& type, const std::string& pointer, const char* name,
                                     Call&& call) {
    pointer_ = &pointer;
    site_.enter(nullptr, type, name);
    if constexpr (std::is_void_v<std::invoke_result_t<Call&>>) {
      call();
      leave();
    } else {
      const auto result = call();
      leave();
      return result;
    }
  }
  Notes notes() {
    return {this, [](void* self, const char* text) {
              auto& calls = *static_cast<ModelCalls*>(self);
              calls.note_book_.keep(*calls.site_.component(), *calls.pointer_, calls.site_.call(), calls.time(), text);
            }};
  }
  std::byte* memory_of(const Place<std::byte>& place) const { return place.count > 0 ? place.in(arena_) : nullptr; }

  std::byte* arena_;
  const std::string* pointer_ = nullptr;
  CallSite site_;
  NoteBook note_book_;
};

}  // namespace binnacle::filter
