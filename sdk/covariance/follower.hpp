// SPDX-License-Identifier: Apache-2.0
// Follows truth and filter along the error-free run: their step observers in, variances over time out.
#pragma once

#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/state_block.hpp"
#include "joint_covariance.hpp"
#include "plan.hpp"
#include "recorder.hpp"

namespace binnacle::covariance {

/// Where a variant cannot be analysed to its end.
struct Broken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Point {
  double t = 0, variance = 0, own_variance = 0;
};

/// What is recorded over time: an error component, a readable output, a norm, or an implied state.
struct Subject {
  std::string name;
  std::string measurement;                // of an implied state; else ""
  const BlockInfo* block = nullptr;       // of the filter
  const BlockInfo* true_block = nullptr;  // null: the truth has none
  std::vector<int> components;            // of the block's error; several: their norm
  int output = -1;                        // >= 0: of the block's readable outputs, instead of components
  std::vector<Point> points;
  Eigen::VectorXd parts;           // the newest variance by source
  std::vector<std::string> names;  // of the sources then
};

class Follower {
 public:
  /// `times`: when variances are wanted though nothing may be measured then. Throws Broken.
  Follower(const Plan& plan, const std::vector<std::string>& names, std::vector<Time> times);
  Follower(const Follower&) = delete;
  Follower& operator=(const Follower&) = delete;

  /// To be attached to the filter and to its truth; null where the filter is its own truth.
  StepObserver* model_log() { return &model_log_; }
  StepObserver* true_log() { return is_own_truth_ ? nullptr : &true_log_; }
  /// Nothing that comes from now on is of use.
  bool is_over() const { return is_over_ || !why_.empty(); }
  /// After the run. Throws Broken, also for what went wrong on the way: step observers must not throw.
  void finish();

  const std::vector<Subject>& subjects() const { return subjects_; }

 private:
  void add_subject(const std::string& name);
  void take(std::deque<Event>& events, Event event);
  void follow();
  void start();
  bool follow_truth_to(const Event& update);
  void follow_truth_to(Time t);
  void measure(const Event& event, const Event& truth);
  void note_blocks();
  void note_implied_states(const Event& event, const Event& truth);
  void note(Subject& subject, Time t, const Eigen::VectorXd& parts, double own_variance);
  Eigen::VectorXd output_row(const Subject& subject) const;
  Eigen::VectorXd joined(const Eigen::VectorXd& of_truth, const Eigen::VectorXd& of_model) const;

  const Plan& plan_;
  const FilterInfo& info_;
  const FilterInfo& true_info_;
  bool is_own_truth_;
  JointCovariance joint_;
  Recorder model_log_, true_log_;
  std::deque<Event> events_, true_events_;  // not yet followed
  std::vector<Time> times_;                 // ascending; those that have not passed
  Eigen::MatrixXd P_;                       // the filter's own
  std::vector<double> x_;                   // its stored state
  Time t_ = no_time;
  bool is_over_ = false;
  std::string why_;  // it broke
  std::vector<Subject> subjects_;
};

}  // namespace binnacle::covariance
