// SPDX-License-Identifier: Apache-2.0
// The step log of one filter over a stretch of time, kept for the backward sweep.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"
#include "binnacle/step_log.hpp"
#include "binnacle/time.hpp"
#include "smooth/co_states.hpp"
#include "smooth/path.hpp"

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

class PathFilter;

/// Takes the step log of a filter, and goes back over it.
///
/// At a restart the co-states begin anew: what came after says nothing about the state before. So they do where recovery
/// scaled P (D P D): P before it was not the covariance of anything.
class Stretch final : public StepObserver {
 public:
  using Take = std::function<void(const Epoch&)>;
  using TakeWithheld = std::function<void(WithheldSample)>;
  using TakePath = std::function<void(const double* x)>;

  Stretch(const Session& session, FilterId filter, const TransitionPattern& pattern, bool has_considered);

  Wants wants() const override;
  void started(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;
  void inflated(const InflationRecord& record) override;

  /// The filter's estimate at t, its a-posteriori one so far, is wanted smoothed: x ⊞ deviation, whose covariance is P.
  void mark(Time t, const double* x, ConstMatrixView P, const double* deviation = nullptr);
  /// The steps that contain one of these times, ascending, are wanted smoothed at both ends.
  void want(std::span<const Time> times) { wanted_ = times; }
  bool is_wanted(Time t0, Time t1) const;

  /// The smoothed state after the start and after each step is given to `take`, and decisions are noted.
  void keep_path(TakePath take) { take_path_ = std::move(take); }
  const Decisions& decisions() const { return decisions_; }
  /// The largest change of the path in the last sweep, over its 1-sigma.
  double largest_change() const { return largest_change_; }
  void forget_change() { largest_change_ = 0; }

  // ---- what a PathFilter logs
  void mark_path(const PathFilter& filter, Time t);
  void add_step(const StepRecord& record);
  void add_update(const UpdateRecord& record);
  /// P is that before the sample, which changes nothing.
  void withhold(const UpdateRecord& record, ConstMatrixView P);

  void clear();
  /// For checkpoints; nothing is held of what keep_path() takes.
  void exchange(StateBytes& bytes);
  /// What of a sweep is wanted: what comes after `after`, up to `until`.
  struct Window {
    Time after = no_time, until = std::numeric_limits<Time>::max();
    bool contains(Time t) const { return t > after && t <= until; }
  };
  /// Takes the co-states from the stretch's end to its begin; marked epochs and withheld samples of the window are given, the
  /// last first.
  void sweep(CoStates& co_states, const Take& take, const TakeWithheld& take_withheld, Window window);
  void sweep(CoStates& co_states, const Take& take, const TakeWithheld& take_withheld) {
    sweep(co_states, take, take_withheld, {});
  }

  /// Where the co-states began anew.
  int breaks() const { return breaks_; }
  /// P was opened, or the filter started anew.
  bool was_opened() const { return was_opened_; }

 private:
  enum class Kind { step, update, variances, cut, mark, path, withheld };
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
  void add_mark(Kind kind, Time t, const double* x, ConstMatrixView P, const double* deviation);
  /// x_ of a mark; delta_ is its correction.
  void move(const Entry& entry, CoStates& co_states);
  Epoch smoothed(const Entry& entry, CoStates& co_states);
  void note_change(ConstMatrixView P);
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
  bool was_opened_ = false;
  TakePath take_path_;
  Decisions decisions_;
  double largest_change_ = 0;
  std::vector<double> x_, delta_, block_delta_, P_;
};

}  // namespace binnacle::smooth
