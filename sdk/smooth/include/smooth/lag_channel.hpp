// SPDX-License-Identifier: Apache-2.0
// A fixed lag whose estimates are samples of the channel NAME.smoothed, for sinks, transforms and other filters.
#pragma once

#include "binnacle/session.hpp"
#include "binnacle/state_bytes.hpp"
#include "smooth/epoch_buffer.hpp"
#include "smooth/fixed_lag.hpp"

namespace binnacle::smooth {

/// In a program that embeds the filter: made before the first sample, and emit() called after each push or commit.
///
///     LagChannel smoothed(session, session.filter("ins"), session.channel("ins.smoothed"), {lag, every});
class LagChannel {
 public:
  /// Attaches itself beside the filter's observer. The session must outlive it, and stay where it is.
  LagChannel(Session& session, FilterId filter, ChannelId channel, Lag lag);
  ~LagChannel();
  LagChannel(const LagChannel&) = delete;
  LagChannel& operator=(const LagChannel&) = delete;

  /// What was swept since the last call: each estimate is an instant of its own, in order of time, behind the filter.
  void emit();
  /// At the end of the data: sweeps and emits all that is left.
  void finish();
  /// For checkpoints, after emit().
  void exchange(StateBytes& bytes) { lag_.exchange(bytes); }

 private:
  Session& session_;
  FilterId filter_;
  ChannelId channel_;
  EpochBuffer epochs_;
  FixedLag lag_;
};

}  // namespace binnacle::smooth
