// SPDX-License-Identifier: Apache-2.0
#include "input_history.hpp"

namespace binnacle::score {

namespace {

constexpr Time hole = 3 * InputHistory::step;

}  // namespace

void InputHistory::add(Time t0, Time t, const Turns& increment) {
  if (t0 == no_time || t <= t0 || (t_ != no_time && t <= t_)) return;
  if (!increment.allFinite()) return;  // leaves a hole
  force_ += increment.tail<3>();
  seconds_ += binnacle::seconds(t - t0);
  if (t_ == no_time || t0 - t_ > hole) {
    first_ = node(t0) + 1;
    newest_ = first_ - 1;
    t_ = t0;
    sum_.setZero();
  }
  const double dt = binnacle::seconds(t - t_);
  for (; (newest_ + 1) * step <= t; ++newest_)
    nodes_[index(newest_ + 1)] = sum_ + increment * (binnacle::seconds((newest_ + 1) * step - t_) / dt);
  sum_ += increment;
  t_ = t;
}

}  // namespace binnacle::score
