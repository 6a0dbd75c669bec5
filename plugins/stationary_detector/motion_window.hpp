// SPDX-License-Identifier: Apache-2.0
// MotionWindow: low-passed inertial samples over the last moments, their mean rate and the scatter of their force.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace binnacle::stationary_detector {

struct WindowSettings {
  double cutoff = 0;  // Hz, −3 dB
  double length = 0;  // s
};

struct WindowFigures {
  Eigen::Vector3d mean_rate;  // rad/s, of the low-passed angular rate
  double force_variance = 0;  // (m/s²)², of the low-passed specific force's length
};

/// Samples of any rate are kept as sums over parts of the window, so its size does not depend on the rate; it advances
/// by one part at a time. Plain memory; all zero is an empty window.
class MotionWindow {
 public:
  static constexpr int parts = 20;

  void clear() { *this = MotionWindow(); }
  /// One sample: mean rates over the dt > 0 seconds since the last. True when it has completed a part, whose length is
  /// then last_part().
  bool add(const WindowSettings& settings, double dt, const Eigen::Vector3d& rate, const Eigen::Vector3d& force);
  bool is_full() const { return count_ >= parts; }
  double last_part() const { return last_part_; }
  /// Only when it is full.
  WindowFigures figures() const;

 private:
  static constexpr int axes = 6;
  struct Part {
    double time;     // s
    double rate[3];  // ∫ dt
    double force;    // ∫ (|f| − g₀) dt
    double force_squared;
  };

  void low_pass(const WindowSettings& settings, double dt, const Eigen::Vector3d& rate, const Eigen::Vector3d& force);

  std::int64_t is_primed_ = 0;
  std::array<std::array<double, axes>, 2> stage_{};  // two poles, one after the other
  std::array<Part, parts> part_{};                   // a ring
  std::int64_t next_ = 0, count_ = 0;
  Part open_{};
  double phase_ = 0;  // s, since the part's due begin: a part is as many samples long as fit on average
  double last_part_ = 0;
};

}  // namespace binnacle::stationary_detector
