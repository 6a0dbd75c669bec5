// SPDX-License-Identifier: Apache-2.0
// Fixed-lag smoothing of a filter while it runs.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"
#include "smooth/co_states.hpp"
#include "smooth/epoch_buffer.hpp"
#include "smooth/stretch.hpp"

namespace binnacle::smooth {

struct Lag {
  Time lag = 0;    // an estimate is smoothed with what came within this time after it, or more
  Time every = 0;  // from one sweep to the next
};

/// Observes a filter (Session::attach) and sweeps back over its newest steps every so often. A sweep emits, in order and
/// once, the estimates after each step that are older than the lag by then; each is that of a fixed-interval smoother over
/// all data up to the sweep. A sweep comes with the first step after it is due, so that all samples of an instant are in it.
/// Each step is swept over lag / every + 1 times. Allocates while the log grows to lag + every, and no more.
class FixedLag final : public StepObserver {
 public:
  using Emit = std::function<void(const Epoch&)>;

  /// take_withheld: gets withheld samples with their sweep; empty: nobody.
  FixedLag(const Session& session, FilterId filter, Lag lag, Emit emit, Stretch::TakeWithheld take_withheld = {});
  FixedLag(const FixedLag&) = delete;
  FixedLag& operator=(const FixedLag&) = delete;

  /// At the end of the data: emits all that is left.
  void finish();
  /// For checkpoints, between two instants.
  void exchange(StateBytes& bytes);
  /// Where the co-states of some sweep began anew, since P was scaled or the filter started anew.
  bool has_breaks() const { return has_breaks_; }

  Wants wants() const override;
  void started(Time t, const double* x, ConstMatrixView P) override;
  void restored(Time t, const double* x, ConstMatrixView P) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;
  void inflated(const InflationRecord& record) override;

 private:
  Stretch& newest() { return *log_.back().stretch; }
  void open_part();
  void sweep(Time until);
  void emit_kept();

  const Session& session_;
  FilterId id_;
  const FilterInfo& filter_;
  Lag lag_;
  Emit emit_;
  Stretch::TakeWithheld take_withheld_;
  TransitionPattern pattern_;
  CoStates co_states_;
  /// The log from one sweep to the next.
  struct Part {
    std::unique_ptr<Stretch> stretch;
    Time end = no_time;  // of its newest estimate
  };
  std::vector<Part> log_, spare_;
  Time next_sweep_ = no_time, emitted_ = no_time;
  bool has_breaks_ = false;
  EpochBuffer kept_;  // of a sweep, the last first
};

}  // namespace binnacle::smooth
