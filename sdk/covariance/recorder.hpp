// SPDX-License-Identifier: Apache-2.0
// What a filter did, as matrices, in the order in which it happens.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "binnacle/composition.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/step_log.hpp"

namespace binnacle::covariance {

struct Event {
  enum Kind { started, stepped, offered } kind = started;
  Time t = 0;
  std::vector<double> x;        // stored state afterwards
  Eigen::MatrixXd P1, Phi, Qd;  // of a step; P1 of the start
  Eigen::MatrixXd S, R, H;      // of a measurement that was linearized
  std::string measurement, reason;
  Outcome outcome = Outcome::rejected;
};

/// Copies every record of a step observer and hands it on.
class Recorder final : public StepObserver {
 public:
  using Take = std::function<void(Event)>;

  Recorder(const FilterInfo& info, Take take) : info_(info), take_(std::move(take)) {}

  Wants wants() const override { return Wants::step_covariance | Wants::transition | Wants::jacobian; }
  void started(Time t, const double* x, ConstMatrixView P) override {
    Event event = event_of(Event::started, t, x);
    event.P1 = P.as();
    take_(std::move(event));
  }
  void stepped(const StepRecord& record) override {
    Event event = event_of(Event::stepped, record.t1, record.x1);
    event.P1 = record.P1.as();
    event.Phi = record.Phi.as();
    event.Qd = record.Qd.as();
    take_(std::move(event));
  }
  void offered(const UpdateRecord& record) override {
    Event event = event_of(Event::offered, record.t, record.x1 ? record.x1 : record.x0);
    event.measurement = info_.measurements[static_cast<std::size_t>(record.measurement)].name;
    event.outcome = record.outcome;
    event.reason = record.reason;
    if (record.H) {
      event.S = record.update_S.as();
      event.R = record.R.as();
      event.H = record.H.as();
    }
    take_(std::move(event));
  }

 private:
  Event event_of(Event::Kind kind, Time t, const double* x) const {
    Event event;
    event.kind = kind;
    event.t = t;
    event.x.assign(x, x + info_.stored_size);
    return event;
  }

  const FilterInfo& info_;
  Take take_;
};

}  // namespace binnacle::covariance
