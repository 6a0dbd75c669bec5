// SPDX-License-Identifier: Apache-2.0
// The step log of one filter over a stretch of time, kept for the backward sweep.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/step_log.hpp"
#include "binnacle/time.hpp"
#include "smooth/co_states.hpp"

namespace binnacle::smooth {

/// A smoothed estimate; spans end with the call that gave them.
struct Epoch {
  Time t = no_time;
  const double* x = nullptr;  // stored state, laid out as FilterInfo gives it
  ConstMatrixView P;
};

/// A withheld sample against the smoothed estimate: its residual is r − H δ, to first order. As UpdateRecord has it.
struct WithheldSample {
  int measurement = 0;
  Time t = no_time;
  std::vector<double> residual;
  std::vector<int> groups;
};

/// Takes the step log of a filter, and goes back over it.
///
/// At a restart the co-states begin anew: what came after says nothing about the state before. So they do where recovery
/// scaled P (D P D): P before it was not the covariance of anything.
class Stretch final : public StepObserver {
 public:
  using Take = std::function<void(const Epoch&)>;
  using TakeWithheld = std::function<void(WithheldSample)>;

  Stretch(const Session& session, FilterId filter, const TransitionPattern& pattern, bool has_considered);

  Wants wants() const override;
  void started(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;
  void inflated(const InflationRecord& record) override;

  /// The filter's estimate at t, its a-posteriori one so far, is wanted smoothed.
  void mark(Time t, const double* x, ConstMatrixView P);
  /// The steps that contain one of these times, ascending, are wanted smoothed at both ends.
  void want(std::span<const Time> times) { wanted_ = times; }

  void clear();
  /// Takes the co-states from the stretch's end to its begin; marked epochs and withheld samples are given, the last first.
  void sweep(CoStates& co_states, const Take& take, const TakeWithheld& take_withheld);

  /// Where the co-states began anew.
  int breaks() const { return breaks_; }

 private:
  enum class Kind { step, update, variances, cut, mark, withheld };
  struct Entry {
    Kind kind;
    int rows = 0;
    bool has_reset = false;
    Time t = no_time;
    std::size_t at = 0;  // in numbers_
  };
  double* add(Kind kind, std::size_t doubles, Time t = no_time);
  double* keep(double* to, ConstMatrixView A);
  /// Reads matrices that keep() wrote.
  UpdateTerms terms_of(const Entry& entry) const;
  Epoch smoothed(const Entry& entry, CoStates& co_states);
  void withhold(const UpdateRecord& record);
  WithheldSample withheld(const Entry& entry, CoStates& co_states);

  const Session& session_;
  FilterId id_;
  const FilterInfo& filter_;
  const TransitionPattern& pattern_;
  bool has_considered_;
  std::vector<Entry> entries_;
  std::vector<double> numbers_;
  std::vector<WithheldSample> withheld_;
  std::span<const Time> wanted_;
  int breaks_ = 0;
  std::vector<double> x_, delta_, block_delta_, P_;
};

}  // namespace binnacle::smooth
