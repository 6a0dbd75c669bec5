// SPDX-License-Identifier: Apache-2.0
#include "sensors.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::ublox {

namespace {

constexpr Time longest_pause = 600 * nanoseconds_per_second;  // after a longer one the clock is another
constexpr Time longest_step = nanoseconds_per_second;         // over which a mean rate is one

/// Types of ESF measurement data.
enum Data : std::uint32_t {
  gyro_z = 5,
  front_left = 6,
  front_right = 7,
  rear_left = 8,
  rear_right = 9,
  single_tick = 10,
  speed = 11,
  gyro_temperature = 12,
  gyro_y = 13,
  gyro_x = 14,
  accel_x = 16,
  accel_y = 17,
  accel_z = 18
};

double signed24(std::uint32_t data) {
  const auto value = static_cast<std::int32_t>(data << 8);
  return static_cast<double>(value >> 8);
}

}  // namespace

Time SensorClock::time_of(std::uint32_t tag) {
  const Time step = last_ ? static_cast<std::int32_t>(tag - *last_) * tick_ : 0;
  last_ = tag;
  if (std::abs(step) > longest_pause) {
    own_ = 0;
    offset_ = no_time;
    ++jumps_;
  } else {
    own_ += step;
  }
  if (epoch_ != no_time) {
    const Time offset = epoch_ - own_;
    const bool has_jumped = offset_ != no_time && std::abs(offset - offset_) > nanoseconds_per_second;
    if (offset_ == no_time || has_jumped) {
      offset_ = offset;
      least_ = most_ = 0;
      jumps_ += has_jumped;
    }
    least_ = std::min(least_, offset - offset_);
    most_ = std::max(most_, offset - offset_);
    epoch_ = no_time;
  }
  return offset_ == no_time ? no_time : own_ + offset_;
}

bool Sensors::add(std::uint32_t tag, std::uint32_t data, std::vector<SensorSample>& complete) {
  if (!tag_ || *tag_ != tag) {
    finish(complete);
    tag_ = tag;
    now_ = clock_.time_of(tag);
  }
  const std::uint32_t type = data >> 24 & 0x3F, raw = data & 0xFFFFFF;
  const auto set = [&](Pending& pending, std::size_t size, std::size_t at, double value) {
    if (pending.values.empty()) pending.values.assign(size, nan);
    pending.t = now_;
    pending.values[at] = value;
  };
  const auto inertial = [&](std::size_t at, double value) { set(inertial_, 7, at, value); };
  const auto wheel = [&](std::size_t at, double value) { set(wheels_, 6, at, value); };
  const double value = signed24(raw);
  // Bit 23: backward.
  const double ticks = (raw & 0x800000) != 0 ? -static_cast<double>(raw & 0x7FFFFF) : static_cast<double>(raw);
  constexpr double gyro_scale = degree / 4096, accel_scale = 1.0 / 1024;
  switch (type) {
    case gyro_x: inertial(0, value * gyro_scale); return true;
    case gyro_y: inertial(1, value * gyro_scale); return true;
    case gyro_z: inertial(2, value * gyro_scale); return true;
    case accel_x: inertial(3, value * accel_scale); return true;
    case accel_y: inertial(4, value * accel_scale); return true;
    case accel_z: inertial(5, value * accel_scale); return true;
    case gyro_temperature: inertial(6, value * 0.01 + 273.15); return true;
    case front_left: wheel(0, ticks); return true;
    case front_right: wheel(1, ticks); return true;
    case rear_left: wheel(2, ticks); return true;
    case rear_right: wheel(3, ticks); return true;
    case single_tick: wheel(4, ticks); return true;
    case speed: wheel(5, value * 1e-3); return true;
    default: return false;
  }
}

void Sensors::close(bool is_wheels, std::vector<SensorSample>& complete) {
  Pending& pending = is_wheels ? wheels_ : inertial_;
  if (pending.values.empty()) return;
  SensorSample sample{pending.t, no_time, std::move(pending.values), is_wheels};
  pending.values.clear();
  if (!is_wheels) {
    const bool follows = sample.t != no_time && last_inertial_ != no_time && sample.t > last_inertial_ &&
                         sample.t - last_inertial_ <= longest_step;
    if (follows) sample.t0 = last_inertial_;
    last_inertial_ = sample.t;
  }
  complete.push_back(std::move(sample));
}

void Sensors::finish(std::vector<SensorSample>& complete) {
  close(false, complete);
  close(true, complete);
}

}  // namespace binnacle::ublox
