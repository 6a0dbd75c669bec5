// SPDX-License-Identifier: Apache-2.0
// MotionWindow: low-passed inertial samples over the last moments, their mean rate and the scatter of their force.
#include "motion_window.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace binnacle::stationary_detector {

namespace {

constexpr double about_gravity = 9.8;  // m/s², taken off before squaring for the digits' sake

}  // namespace

// Two equal poles at ω, whose product is −3 dB at the cutoff when ω² = (2π cutoff)²/(√2 − 1). Each is stepped exactly
// for an input that is constant over dt, so any sample rate and a jitter of it will do.
void MotionWindow::low_pass(const WindowSettings& settings, double dt, const Eigen::Vector3d& rate,
                            const Eigen::Vector3d& force) {
  const double omega = 2.0 * std::numbers::pi * settings.cutoff / std::sqrt(std::numbers::sqrt2 - 1.0);
  const double gain = is_primed_ != 0 ? -std::expm1(-omega * dt) : 1.0;
  is_primed_ = 1;
  for (std::size_t i = 0; i < axes; ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    stage_[0][i] += gain * ((i < 3 ? rate[axis] : force[axis]) - stage_[0][i]);
    stage_[1][i] += gain * (stage_[0][i] - stage_[1][i]);
  }
}

bool MotionWindow::add(const WindowSettings& settings, double dt, const Eigen::Vector3d& rate,
                       const Eigen::Vector3d& force) {
  low_pass(settings, dt, rate, force);
  const auto& low = stage_[1];
  const double length = std::hypot(low[3], low[4], low[5]) - about_gravity;
  open_.time += dt;
  for (std::size_t i = 0; i < 3; ++i) open_.rate[i] += low[i] * dt;
  open_.force += length * dt;
  open_.force_squared += length * length * dt;
  const double part_length = settings.length / parts;
  phase_ += dt;
  if (phase_ < part_length - 0.5 * dt) return false;

  phase_ = std::min(phase_ - part_length, part_length);
  next_ = next_ >= 0 && next_ < parts ? next_ : 0;
  part_[static_cast<std::size_t>(next_)] = open_;
  next_ = (next_ + 1) % parts;
  count_ = std::min<std::int64_t>(count_, parts - 1) + 1;
  last_part_ = open_.time;
  open_ = {};
  return true;
}

WindowFigures MotionWindow::figures() const {
  Part sum{};
  for (const Part& part : part_) {
    sum.time += part.time;
    for (std::size_t i = 0; i < 3; ++i) sum.rate[i] += part.rate[i];
    sum.force += part.force;
    sum.force_squared += part.force_squared;
  }
  const double mean = sum.force / sum.time;
  return {Eigen::Vector3d(sum.rate[0], sum.rate[1], sum.rate[2]) / sum.time,
          std::max(0.0, sum.force_squared / sum.time - mean * mean)};
}

}  // namespace binnacle::stationary_detector
