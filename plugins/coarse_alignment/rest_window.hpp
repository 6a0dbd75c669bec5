// SPDX-License-Identifier: Apache-2.0
// RestWindow: is the IMU at rest, and what does it measure on average while it is?
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>

namespace binnacle::coarse_alignment {

/// When a stretch of samples counts as rest. Standard deviations are of single samples, per axis.
struct RestLimits {
  double duration = 0;           // s, averaged
  double specific_force_sd = 0;  // m/s²
  double rate_sd = 0;            // rad/s
  double rate = 0;               // rad/s, of the mean, bias included
  double gravity_error = 0;      // m/s², | |f| − g |
};

/// What kept stretches of samples from counting as rest: for messages.
struct RestFindings {
  static constexpr int criteria =
      4;  // scatter of specific force, scatter of rate, mean rate, gravity: as in RestLimits
  std::int64_t stretches = 0;
  std::array<std::int64_t, criteria> failed{};  // how many stretches
  std::array<double, criteria> least{};         // of those that failed
  double specific_force = 0;                    // length of the newest mean, m/s²

  void see(const RestLimits& limits, const std::array<double, criteria>& values, double new_specific_force);
  static std::array<double, criteria> limits_of(const RestLimits& limits) {
    return {limits.specific_force_sd, limits.rate_sd, limits.rate, limits.gravity_error};
  }
};

/// Means over the window, and the variance of each mean as the scatter of its parts gives it.
struct RestMeans {
  Eigen::Vector3d rate;            // rad/s
  Eigen::Vector3d specific_force;  // m/s²
  double rate_variance = 0;        // of the worst axis
  double specific_force_variance = 0;
};

/// The window is eight blocks long, and one more has to be quiet after them before they count: motion that begins so
/// gently that its own block passes as quiet is not in the mean. Plain memory; all zero is an empty window.
class RestWindow {
 public:
  static constexpr int blocks = 8;

  enum class Event : std::int64_t { none, at_rest, disturbed };

  void clear();
  /// One sample: mean rates over dt > 0 seconds. `at_rest` when a quiet block has completed a full window.
  Event add(const RestLimits& limits, double dt, const Eigen::Vector3d& rate, const Eigen::Vector3d& specific_force,
            RestFindings& findings);
  /// Only after `at_rest`.
  RestMeans means() const;

 private:
  static constexpr int axes = 6;  // three rates, three specific forces
  static constexpr int capacity = blocks + 1;
  using Means = std::array<double, axes>;

  static bool is_quiet(const RestLimits& limits, const Means& mean, const Means& variance, RestFindings& findings);
  bool is_like_the_others(const RestLimits& limits, const Means& mean) const;
  Means mean_of_the_oldest(std::int64_t number) const;

  std::array<Means, capacity> block_{};  // the oldest first
  std::int64_t count_ = 0;
  double time_ = 0;  // of the open block, s
  Means sum_{};
  Means sum_of_squares_{};
};

}  // namespace binnacle::coarse_alignment
