// SPDX-License-Identifier: Apache-2.0
// Labels of live samples that lie far ahead of those before.
#pragma once

#include "binnacle/time.hpp"

namespace binnacle::line_input {

/// A label more than `max_ahead` after the newest one is wrong, unless the source was silent for half as long. If labels go
/// on from it, four of them over at least 3 s, with none of the others between, the clock jumped, ahead or back. What lies
/// far behind is not left out: filters count it as late.
class LabelGuard {
 public:
  explicit LabelGuard(Time max_ahead) : max_ahead_(max_ahead) {}

  /// `arrival`: by a clock of this machine. False: leave the sample out.
  bool accepts(Time label, Time arrival);
  /// The label that was accepted last is the first after a jump of the clock.
  bool is_anew() const { return is_anew_; }

 private:
  Time max_ahead_;
  Time newest_ = no_time, arrival_ = no_time;         // of what was accepted
  Time suspect_ = no_time, suspect_since_ = no_time;  // the newest that is far off, and the first that it goes on from
  int suspects_ = 0;
  bool is_anew_ = false;
};

}  // namespace binnacle::line_input
