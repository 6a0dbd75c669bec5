// SPDX-License-Identifier: Apache-2.0
// Which instants a record takes: the nearest to each multiple of an interval, labels that jitter included.
#pragma once

#include <algorithm>

#include "binnacle/time.hpp"

namespace binnacle::score {

/// Points of a grid at first + k · every, first being the first instant. Of each point that instant is taken which is
/// nearest to it among the first at or after it and those before it by at most a tenth of `every` and less than half the
/// time to the instant before (so that regular data, which hit the grid, are not looked at twice); of two that are as
/// near the later. A point that no instant is near is skipped. every = 0: every instant.
class RecordEpochs {
 public:
  enum class Choice {
    skip,     // not this one
    take,     // this one; what was kept for later is void
    keep,     // perhaps this one: remember it, and forget what was kept before
    release,  // not this one, but what was kept
    release_and_take,
    release_and_keep
  };

  explicit RecordEpochs(Time every = 0) : every_(every) {}

  /// Instants come in order of time.
  Choice on(Time t) {
    const Time tolerance = previous_ == no_time ? 0 : std::min(every_ / 10, (t - previous_ - 1) / 2);
    previous_ = t;
    if (every_ <= 0) return Choice::take;
    if (point_ == no_time) {
      point_ = t + every_;
      return Choice::take;
    }
    if (kept_ == no_time) return fresh(t, tolerance, Choice::take, Choice::keep, Choice::skip);
    if (point_ - kept_ >= (t > point_ ? t - point_ : point_ - t)) {  // nearer than what was kept
      kept_ = no_time;
      return fresh(t, every_, Choice::take, Choice::keep, Choice::skip);
    }
    kept_ = no_time;
    point_ += every_;
    return fresh(t, tolerance, Choice::release_and_take, Choice::release_and_keep, Choice::release);
  }

  /// At the end: whether what was kept is taken.
  bool finish() { return kept_ != no_time; }

 private:
  Choice fresh(Time t, Time tolerance, Choice take, Choice keep, Choice skip) {
    if (t >= point_) {
      point_ += (1 + (t - point_) / every_) * every_;
      return take;
    }
    if (point_ - t > tolerance) return skip;
    kept_ = t;
    return keep;
  }

  Time every_;
  Time point_ = no_time;  // the next that wants an instant
  Time previous_ = no_time;
  Time kept_ = no_time;  // before point_
};

}  // namespace binnacle::score
