// SPDX-License-Identifier: Apache-2.0
// From the step log of a run to a LinearLog, and from that of a run with other noise to its slopes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "binnacle/parameters.hpp"
#include "binnacle/session.hpp"
#include "binnacle/step_log.hpp"
#include "smooth/co_states.hpp"
#include "tune/linear_log.hpp"

namespace binnacle::tune {

/// The end of what is used, which may count from the filter's start.
class Until {
 public:
  explicit Until(const std::optional<When>& when) : when_(when) {}
  void started(Time t) {
    if (start_ == no_time) start_ = t;
  }
  bool is_over(Time t) const {
    return when_ && start_ != no_time && t > when_->time + (when_->from_start ? start_ : 0);
  }

 private:
  std::optional<When> when_;
  Time start_ = no_time;
};

/// A sample that an update was made of: which one, and whose rows.
struct AcceptedSample {
  int measurement = 0;
  Time t = no_time;
  std::vector<std::int64_t> keys;
  std::vector<int> groups;
  std::size_t event = 0;  // of the log
};

struct RefusedSample {
  int measurement = 0;
  Time t = no_time;
};

/// A run of one filter, up to a time.
struct RecordedRun {
  explicit RecordedRun(const FilterInfo& filter) : pattern(filter), log(filter.dof) {}

  smooth::TransitionPattern pattern;
  LinearLog log;
  std::vector<double> Phi;          // of every step, gathered
  std::vector<int> event_of_step;   // −1: no update followed
  std::vector<std::size_t> starts;  // events that are starts of the filter
  std::vector<AcceptedSample> accepted;
  std::vector<RefusedSample> refused;  // or thinned out
  int rows = 0, rows_refused = 0, recoveries = 0;
  double nis = 0;
};

/// A ← Φ A Φᵀ with gathered Φ, A symmetric.
void carry(const smooth::TransitionPattern& pattern, const double* phi, Eigen::MatrixXd& A, Eigen::MatrixXd& scratch);

/// The run that is linearized about.
class LogRecorder final : public StepObserver {
 public:
  LogRecorder(const FilterInfo& filter, RecordedRun& run, const Until& until);

  Wants wants() const override;
  void started(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;
  void inflated(const InflationRecord& record) override;

 private:
  /// The steps since the last event become one.
  void flush();
  void forget_steps();

  RecordedRun& run_;
  Until until_;
  std::size_t first_ = 0;  // step that is in no event yet
  Eigen::MatrixXd PhiT_, Q_, scratch_;
};

/// The same run with one parameter changed a little: its noise at the same places, less that of the run, over `change`.
/// Qd is carried along by the run's own Φ.
class SlopeRecorder final : public StepObserver {
 public:
  SlopeRecorder(const RecordedRun& run, int dof, double change, const Until& until);

  Wants wants() const override { return Wants::transition; }
  void started(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;

  /// By event. Of samples that this run refused, or took other rows of, there is none: missed().
  std::vector<SparseTerm>& terms() { return terms_; }
  int missed() const { return missed_ + static_cast<int>(run_.accepted.size() - next_); }
  /// Whether it took the same steps, and started as often.
  bool is_alike() const { return step_ == run_.event_of_step.size() && start_ == run_.starts.size(); }

 private:
  void set(std::size_t event, const Eigen::MatrixXd& noise);

  const RecordedRun& run_;
  double change_;
  Until until_;
  std::size_t step_ = 0, start_ = 0, next_ = 0;
  int missed_ = 0;
  std::vector<SparseTerm> terms_;
  Eigen::MatrixXd Q_, scratch_;
};

}  // namespace binnacle::tune
