// SPDX-License-Identifier: Apache-2.0
// Windows of a run, and what the step log of a filter says of the information in them.
#pragma once

#include <cstdint>
#include <list>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/composition.hpp"
#include "binnacle/session.hpp"
#include "binnacle/step_log.hpp"
#include "observe/information.hpp"
#include "smooth/co_states.hpp"

namespace binnacle::observe {

/// A stretch of a run that is looked at by itself.
struct Window {
  std::string name;
  TimeSpan span;
};

/// An accepted sample, to be found again in another run.
struct Accepted {
  int measurement = 0;
  Time t = no_time;
  std::vector<int> groups;         // per row
  std::vector<std::int64_t> keys;  // per row
  Eigen::MatrixXd R;               // as it was used
};

/// One window of one filter. It begins with the filter's a-posteriori P at `from`, the last instant of the filter that is not
/// after the window's begin, or its start; samples later than that, up to the window's end, count.
struct Stay {
  Stay(const smooth::TransitionPattern& pattern, std::string name, Time from, Eigen::MatrixXd P, int measurements);

  std::string name;
  Time from = no_time, to = no_time;  // to: of what came last
  Time until = no_time;               // the window's end
  bool at_start = false;              // began with the filter: samples of that instant count
  bool restarted = false;             // ended because the filter started anew
  int opened = 0;                     // P was opened for refused samples
  int singular = 0;                   // samples whose S was not positive definite; they do not count
  Eigen::MatrixXd P0;
  Information with_noise, without_noise;
  History history;  // of with_noise
  std::vector<Accepted> accepted;
};

/// Collects the windows of one filter while it runs. Where the filter starts anew, windows end, and go on as others.
class FilterWatch final : public StepObserver {
 public:
  FilterWatch(const FilterInfo& filter, std::vector<Window> windows);
  FilterWatch(const FilterWatch&) = delete;
  FilterWatch& operator=(const FilterWatch&) = delete;

  Wants wants() const override;
  void started(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;
  void inflated(const InflationRecord& record) override;

  const FilterInfo& filter() const { return filter_; }
  const smooth::TransitionPattern& pattern() const { return pattern_; }
  /// Those that the filter was in, in order of their begin.
  const std::list<Stay>& stays() const { return stays_; }

 private:
  Time begin(const Window& window) const { return window.span.from + (window.span.from_is_relative ? start_ : 0); }
  Time end(const Window& window) const { return window.span.to + (window.span.to_is_relative ? start_ : 0); }
  void open(const Window& window, std::string name, Time t, ConstMatrixView P, bool at_start);

  const FilterInfo& filter_;
  smooth::TransitionPattern pattern_;
  std::vector<Window> windows_;
  std::vector<bool> is_pending_;  // by window
  Time start_ = no_time;
  std::list<Stay> stays_;
  std::vector<Stay*> open_;
  std::vector<double> phi_;
};

}  // namespace binnacle::observe
