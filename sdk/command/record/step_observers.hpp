// SPDX-License-Identifier: Apache-2.0
// The step log of one filter for several.
#pragma once

#include <vector>

#include "binnacle/step_log.hpp"

namespace binnacle::command {

/// Each gets everything, in the order in which they were added, and whatever one of them wants is computed.
class StepObservers final : public StepObserver {
 public:
  /// Null is left out.
  void add(StepObserver* observer) {
    if (observer) all_.push_back(observer);
  }
  /// What a run is given: null where there is none, the one where there is one.
  StepObserver* joined() { return all_.empty() ? nullptr : all_.size() == 1 ? all_.front() : this; }

  Wants wants() const override {
    Wants all = Wants::nothing;
    for (const auto* observer : all_) all = all | observer->wants();
    return all;
  }
  const double* nominal() override {
    for (auto* observer : all_)
      if (const double* const x = observer->nominal()) return x;
    return nullptr;
  }
  void started(Time t, const double* x, ConstMatrixView P) override {
    for (auto* observer : all_) observer->started(t, x, P);
  }
  void rewound(Time t) override {
    for (auto* observer : all_) observer->rewound(t);
  }
  void restored(Time t, const double* x, ConstMatrixView P) override {
    for (auto* observer : all_) observer->restored(t, x, P);
  }
  void stepped(const StepRecord& record) override {
    for (auto* observer : all_) observer->stepped(record);
  }
  void offered(const UpdateRecord& record) override {
    for (auto* observer : all_) observer->offered(record);
  }
  void inflated(const InflationRecord& record) override {
    for (auto* observer : all_) observer->inflated(record);
  }

 private:
  std::vector<StepObserver*> all_;
};

}  // namespace binnacle::command
