// SPDX-License-Identifier: Apache-2.0
// The ride: how the body moves against the path that it drives.
#include "ride.hpp"

#include <algorithm>
#include <cmath>

#include "random/normal.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::vehicle_simulator {

namespace {

using Eigen::Vector3d;

constexpr std::uint64_t draws_of_boarding = 64;  // of one boarding

/// A function of time with its first two derivatives.
struct Jet {
  double value, first, second;
};

Jet operator+(const Jet& a, const Jet& b) { return {a.value + b.value, a.first + b.first, a.second + b.second}; }

Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2 * a.first * b.first + a.value * b.second};
}

/// g(v) = v/√(v² + h²) along v(t).
Jet share_along(const Course& course, double half_speed) {
  const double v = course.speed, h2 = half_speed * half_speed;
  const double root = std::sqrt(v * v + h2);
  const double by_v = h2 / (root * root * root), by_vv = -3.0 * v * by_v / (root * root);
  return {v / root, by_v * course.acceleration, by_vv * course.acceleration * course.acceleration + by_v * course.jerk};
}

Jet jet(const SplineNoise::Value& noise, double size) {
  return {size * noise.value, size * noise.first, size * noise.second};
}

/// Moves the point by `forward`, `right` and `down` [m] from the path, whose heading turns meanwhile.
void move(const Jet& forward, const Jet& right, const Jet& down, const Course& course, Motion& motion) {
  const Vector3d e_forward{course.heading.cos, course.heading.sin, 0},
      e_right{-course.heading.sin, course.heading.cos, 0};
  const Vector3d e_down{0, 0, 1};
  // ė_right = −ψ̇ e_forward, ė_forward = ψ̇ e_right.
  const double turn = course.turn_rate, turn2 = turn * turn, bend = course.turn_acceleration;
  motion.lla =
      strapdown::position_plus(motion.lla, forward.value * e_forward + right.value * e_right + down.value * e_down);
  motion.v_n += (forward.first - right.value * turn) * e_forward + (right.first + forward.value * turn) * e_right +
                down.first * e_down;
  motion.dv_n += (forward.second - forward.value * turn2 - 2 * right.first * turn - right.value * bend) * e_forward +
                 (right.second - right.value * turn2 + 2 * forward.first * turn + forward.value * bend) * e_right +
                 down.second * e_down;
}

/// 64 τ³(1 − τ)³ over [begin, begin + duration].
Jet push(double t, double begin, double duration) {
  const double x = (t - begin) / duration;
  if (!(x > 0.0 && x < 1.0)) return {0, 0, 0};
  const double y = 1.0 - x, xy = x * y, d = y - x;
  return {64 * xy * xy * xy, 192 * xy * xy * d / duration, 384 * xy * (d * d - xy) / (duration * duration)};
}

}  // namespace

Ride::Ride(const RideModel& model, const std::vector<Segment>& segments)
    : model_(model),
      drives_(model.sway > 0 || model.heave > 0 || model.roll > 0 || model.pitch > 0),
      rocks_(model.rocking > 0),
      boards_(model.boarding_every > 0 &&
              (model.boarding_heave > 0 || model.boarding_roll > 0 || model.boarding_pitch > 0)),
      noise_(model.frequency) {
  is_still_ = model.slip == 0 && !drives_ && !rocks_ && !boards_;
  if (!boards_) return;
  std::int64_t boardings = 0;
  for (const Segment& segment : segments) {
    if (segment.speed != 0.0 || segment.acceleration != 0.0) continue;
    const double begin = std::max(seconds(segment.begin), model.boarding_after);
    const double end = seconds(segment.begin + segment.duration);
    if (end - begin < model.boarding_every) continue;
    stops_.push_back({begin, end, boardings});
    boardings += static_cast<std::int64_t>((end - begin) / model.boarding_every);
  }
}

RideMemory Ride::start(std::uint64_t seed) {
  return {.sway = SplineNoise::start(seed, "ride.sway"),
          .heave = SplineNoise::start(seed, "ride.heave"),
          .roll = SplineNoise::start(seed, "ride.roll"),
          .pitch = SplineNoise::start(seed, "ride.pitch"),
          .rocking = {SplineNoise::start(seed, "ride.rocking.x"), SplineNoise::start(seed, "ride.rocking.y"),
                      SplineNoise::start(seed, "ride.rocking.z")},
          .boarding = random::stream(seed, "boarding"),
          .event = -1,
          .event_begin = 0,
          .event_size = {}};
}

double Ride::share(double speed) const { return speed / std::hypot(speed, model_.half_speed); }

void Ride::apply(double t, const Course& course, Motion& motion, RideMemory& memory) const {
  // Slip: the body points into the curve by slip times the lateral acceleration, so it moves outwards across itself.
  motion.roll_pitch_yaw[2] += model_.slip * course.speed * course.turn_rate;
  motion.euler_rates[2] +=
      model_.slip * (course.acceleration * course.turn_rate + course.speed * course.turn_acceleration);
  const bool moves = course.speed != 0.0 || course.acceleration != 0.0 || course.jerk != 0.0;
  if (rocks_ || (moves && (model_.sway > 0 || model_.heave > 0))) displace(t, course, motion, memory);
  if (moves && (model_.roll > 0 || model_.pitch > 0)) lean(t, course, motion, memory);
  if (boards_ && course.speed == 0.0) board(t, motion, memory);
}

void Ride::displace(double t, const Course& course, Motion& motion, RideMemory& memory) const {
  const Jet driving = share_along(course, model_.half_speed);
  const Jet standing{1.0 - driving.value, -driving.first, -driving.second};
  Jet along[3] = {};  // forward, right, down
  const auto add = [&](int axis, const Jet& share, double size, SplineMemory& spline) {
    if (size > 0) along[axis] = along[axis] + share * jet(noise_.at(t, spline), size);
  };
  add(1, driving, model_.sway, memory.sway);
  add(2, driving, model_.heave, memory.heave);
  for (int axis = 0; axis < 3; ++axis) add(axis, standing, model_.rocking, memory.rocking[axis]);
  move(along[0], along[1], along[2], course, motion);
}

void Ride::lean(double t, const Course& course, Motion& motion, RideMemory& memory) const {
  const Jet share = share_along(course, model_.half_speed);
  const auto turn = [&](int angle, double size, SplineMemory& spline) {
    if (!(size > 0)) return;
    const SplineNoise::Value noise = noise_.at(t, spline);
    motion.roll_pitch_yaw[angle] += size * share.value * noise.first;
    motion.euler_rates[angle] += size * (share.first * noise.first + share.value * noise.second);
  };
  turn(0, model_.roll, memory.roll);
  turn(1, model_.pitch, memory.pitch);
}

void Ride::board(double t, Motion& motion, RideMemory& memory) const {
  const auto after = std::upper_bound(stops_.begin(), stops_.end(), t,
                                      [](double time, const Stop& stop) { return time < stop.begin; });
  if (after == stops_.begin()) return;
  const Stop& stop = *(after - 1);
  const double slot = std::floor((t - stop.begin) / model_.boarding_every);
  if (stop.begin + (slot + 1) * model_.boarding_every > stop.end) return;
  const std::int64_t event = stop.first + static_cast<std::int64_t>(slot);
  if (memory.event != event) {
    random::Philox stream = memory.boarding;
    stream.discard(draws_of_boarding * static_cast<std::uint64_t>(event));
    const double uniform = static_cast<double>(stream() >> 11) * 0x1p-53;
    memory.event_begin =
        stop.begin + slot * model_.boarding_every + uniform * (model_.boarding_every - model_.boarding_duration);
    memory.event_size[0] = model_.boarding_heave * random::normal(stream);
    memory.event_size[1] = model_.boarding_roll * random::normal(stream);
    memory.event_size[2] = model_.boarding_pitch * random::normal(stream);
    memory.event = event;
  }
  const Jet p = push(t, memory.event_begin, model_.boarding_duration);
  motion.lla[2] -= memory.event_size[0] * p.value;
  motion.v_n[2] += memory.event_size[0] * p.first;
  motion.dv_n[2] += memory.event_size[0] * p.second;
  for (int angle : {0, 1}) {
    motion.roll_pitch_yaw[angle] += memory.event_size[1 + angle] * p.value;
    motion.euler_rates[angle] += memory.event_size[1 + angle] * p.first;
  }
}

}  // namespace binnacle::vehicle_simulator
