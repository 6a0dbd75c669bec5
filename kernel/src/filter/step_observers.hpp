// SPDX-License-Identifier: Apache-2.0
// The step observers of one filter: that of the run and that of a section's part, either of which may be missing.
#pragma once

#include <type_traits>

#include "binnacle/step_log.hpp"

namespace binnacle::internal::filter {

class StepObservers final : public StepObserver {
 public:
  StepObservers() = default;
  StepObservers(StepObserver* of_run, StepObserver* of_section) : of_run_(of_run), of_section_(of_section) {}

  StepObserver* of_run() const { return of_run_; }
  StepObserver* of_section() const { return of_section_; }
  /// Through which all are reached; null: there is none.
  StepObserver* any() { return !of_section_ ? of_run_ : !of_run_ ? of_section_ : this; }

  Wants wants() const override { return of_run_->wants() | of_section_->wants(); }
  const double* nominal() override { return of_run_->nominal(); }
  void started(Time t, const double* x, ConstMatrixView P) override { each(&StepObserver::started, t, x, P); }
  void rewound(Time t) override { each(&StepObserver::rewound, t); }
  void restored(Time t, const double* x, ConstMatrixView P) override { each(&StepObserver::restored, t, x, P); }
  void stepped(const StepRecord& record) override { each(&StepObserver::stepped, record); }
  void offered(const UpdateRecord& record) override { each(&StepObserver::offered, record); }
  void inflated(const InflationRecord& record) override { each(&StepObserver::inflated, record); }

 private:
  template <class... Arguments>
  void each(void (StepObserver::*call)(Arguments...), std::type_identity_t<Arguments>... arguments) {
    (of_section_->*call)(arguments...);
    (of_run_->*call)(arguments...);
  }

  StepObserver* of_run_ = nullptr;
  StepObserver* of_section_ = nullptr;
};

}  // namespace binnacle::internal::filter
