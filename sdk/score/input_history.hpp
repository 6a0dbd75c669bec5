// SPDX-License-Identifier: Apache-2.0
// The integrals of an inertial input over the last minute, on a grid of time.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "binnacle/state_bytes.hpp"
#include "binnacle/time.hpp"

namespace binnacle::score {

using Turns = Eigen::Matrix<double, 6, 1>;  // ∫ angular rate [rad], ∫ specific force [m/s]

class InputHistory {
 public:
  static constexpr Time step = nanoseconds_per_second / 10;

  InputHistory() : nodes_(640, Turns::Zero()) {}

  /// A sample over (t0, t]. After a hole, or one that is not finite, the history begins anew.
  void add(Time t0, Time t, const Turns& increment);

  /// Whether the integrals up to a and up to b are known, a < b.
  bool has(Time a, Time b) const { return newest_ >= first_ && node(a) >= oldest() && node(b) + 1 <= newest_; }
  /// Whether those up to a are no longer, or never will be.
  bool is_past(Time a) const { return newest_ >= first_ && node(a) < oldest(); }

  void exchange(StateBytes& bytes) {
    for (auto& node : nodes_) bytes.matrix(node);
    bytes.value(first_);
    bytes.value(newest_);
    bytes.value(t_);
    bytes.matrix(sum_);
    bytes.matrix(force_);
    bytes.value(seconds_);
  }

  static std::int64_t node(Time t) { return t / step - (t % step < 0); }
  const Turns& at(std::int64_t node) const { return nodes_[index(node)]; }

  /// The mean specific force of all that came, whatever was forgotten.
  Eigen::Vector3d mean_force() const { return seconds_ > 0 ? force_ / seconds_ : force_; }
  double seconds() const { return seconds_; }

 private:
  std::int64_t oldest() const { return std::max(first_, newest_ - static_cast<std::int64_t>(nodes_.size()) + 1); }
  std::size_t index(std::int64_t node) const {
    const auto size = static_cast<std::int64_t>(nodes_.size());
    return static_cast<std::size_t>((node % size + size) % size);
  }

  std::vector<Turns> nodes_;
  std::int64_t first_ = 0, newest_ = -1;
  Time t_ = no_time;
  Turns sum_ = Turns::Zero();  // up to t_
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();
  double seconds_ = 0;
};

}  // namespace binnacle::score
