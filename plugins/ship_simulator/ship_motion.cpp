// SPDX-License-Identifier: Apache-2.0
// The ship as a rigid body over the rotating earth.
#include "ship_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::ship_simulator {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using simulation::Angle;
using simulation::Inertial;
using simulation::Motion;

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

Matrix3d C_nm(const State& state) {
  return strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(state.euler));
}

/// ω_in of navigation axes that follow the MINS, and its derivative by components:
///   ((Ω + l̇) cos L, −L̇, −(Ω + l̇) sin L)
struct FrameRate {
  Vector3d omega, derivative;
};
FrameRate frame_rate(const State& s) {
  const Angle lat(s.lla[0]);
  const double turning = strapdown::wgs84::omega_ie + s.lla_rate[1];
  const double lat_rate = s.lla_rate[0], faster = s.lla_acceleration[1];
  return {{turning * lat.cos, -lat_rate, -turning * lat.sin},
          {faster * lat.cos - turning * lat.sin * lat_rate, -s.lla_acceleration[0],
           -faster * lat.sin - turning * lat.cos * lat_rate}};
}

/// ω_nm in ship axes from Euler rates, and its derivative.
FrameRate body_rate(const State& s) {
  const Angle roll(s.euler[0]), pitch(s.euler[1]);
  const double p = s.euler_rate[0], q = s.euler_rate[1], r = s.euler_rate[2];
  const Vector3d& a = s.euler_acceleration;
  return {{p - r * pitch.sin, q * roll.cos + r * roll.sin * pitch.cos, -q * roll.sin + r * roll.cos * pitch.cos},
          {a[0] - a[2] * pitch.sin - r * q * pitch.cos,
           a[1] * roll.cos - q * p * roll.sin + a[2] * roll.sin * pitch.cos +
               r * (p * roll.cos * pitch.cos - q * roll.sin * pitch.sin),
           -a[1] * roll.sin - q * p * roll.cos + a[2] * roll.cos * pitch.cos -
               r * (p * roll.sin * pitch.cos + q * roll.cos * pitch.sin)}};
}

/// q_en, the rotation Rz(lon) Ry(−π/2 − lat).
Vector4d q_en(double lat, double lon) {
  const double half_lat = -0.25 * std::numbers::pi - 0.5 * lat;
  return strapdown::quaternion_product({std::cos(0.5 * lon), 0.0, 0.0, std::sin(0.5 * lon)},
                                       {std::cos(half_lat), 0.0, std::sin(half_lat), 0.0});
}

Vector3d position_at_lever_arm(const State& state, const Vector3d& lever_arm_n) {
  return strapdown::lla_from_ecef(strapdown::ecef_from_lla(state.lla) +
                                  strapdown::C_en(state.lla[0], state.lla[1]) * lever_arm_n);
}

// v_N = L̇ (R_m + h), v_E = l̇ (R_t + h) cos L, v_D = −ḣ and their derivatives.
Motion motion(const State& s, const Angle& lat, const strapdown::Radii& r) {
  const double meridian = r.meridian + s.lla[2], transverse = r.transverse + s.lla[2];
  const Vector3d& rate = s.lla_rate;
  Motion m;
  m.lla = s.lla;
  m.v_n << rate[0] * meridian, rate[1] * transverse * lat.cos, -rate[2];
  m.dv_n << s.lla_acceleration[0] * meridian + rate[0] * (r.d_meridian * rate[0] + rate[2]),
      s.lla_acceleration[1] * transverse * lat.cos +
          rate[1] * ((r.d_transverse * rate[0] + rate[2]) * lat.cos - transverse * lat.sin * rate[0]),
      -s.lla_acceleration[2];
  m.roll_pitch_yaw = s.euler;
  m.euler_rates = s.euler_rate;
  return m;
}

}  // namespace

ShipMotion::ShipMotion(const Course& course, const std::array<std::vector<Tone>, freedoms>& tones)
    : course_(course), tones_(tones), sin_heading_(std::sin(course.heading)), cos_heading_(std::cos(course.heading)) {
  const strapdown::Radii radii = strapdown::radii(course.lla[0]);
  north_to_lat_ = 1.0 / (radii.meridian + course.lla[2]);
  east_to_lon_ = 1.0 / ((radii.transverse + course.lla[2]) * std::cos(course.lla[0]));
}

std::size_t ShipMotion::tone_count() const {
  std::size_t count = 0;
  for (const auto& tones : tones_) count += tones.size();
  return count;
}

double ShipMotion::largest_omega() const {
  double largest = 0.0;
  for (const auto& tones : tones_)
    for (const Tone& tone : tones) largest = std::max(largest, tone.omega);
  return largest;
}

State ShipMotion::at(double t, const double* phases) const {
  Waves waves;
  for (std::size_t k = 0; k < freedoms; ++k)
    for (const Tone& tone : tones_[k]) {
      const double argument = tone.omega * t + *phases++;
      const double value = tone.amplitude * std::sin(argument);
      waves.value[k] += value;
      waves.rate[k] += tone.amplitude * tone.omega * std::cos(argument);
      waves.acceleration[k] -= tone.omega * tone.omega * value;
    }
  return state(t, waves);
}

std::array<State, 2> ShipMotion::around(double middle, double offset, const double* phases) const {
  Waves before, after;
  for (std::size_t k = 0; k < freedoms; ++k)
    for (const Tone& tone : tones_[k]) {
      const double argument = tone.omega * middle + *phases++;
      const double s = tone.amplitude * std::sin(argument), c = tone.amplitude * std::cos(argument);
      // sin(a ∓ x) = sin a cos x ∓ cos a sin x, with the series of sin x and cos x to 1e-16
      const double x = tone.omega * offset, x2 = x * x;
      const double sin_x = x * (1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0)));
      const double cos_x = 1.0 - x2 / 2.0 * (1.0 - x2 / 12.0 * (1.0 - x2 / 30.0 * (1.0 - x2 / 56.0)));
      const double sum = s * cos_x, difference = c * sin_x;
      const double rate_sum = c * cos_x, rate_difference = s * sin_x;
      const double square = tone.omega * tone.omega;
      before.value[k] += sum - difference;
      after.value[k] += sum + difference;
      before.rate[k] += tone.omega * (rate_sum + rate_difference);
      after.rate[k] += tone.omega * (rate_sum - rate_difference);
      before.acceleration[k] -= square * (sum - difference);
      after.acceleration[k] -= square * (sum + difference);
    }
  return {state(middle - offset, before), state(middle + offset, after)};
}

State ShipMotion::state(double t, const Waves& w) const {
  const auto north = [&](double ahead, double right) { return cos_heading_ * ahead - sin_heading_ * right; };
  const auto east = [&](double ahead, double right) { return sin_heading_ * ahead + cos_heading_ * right; };
  const auto angles = [&](double north_m, double east_m, double down_m) {
    return Vector3d(north_to_lat_ * north_m, east_to_lon_ * east_m, -down_m);
  };
  const double ahead = course_.speed * t + w.value[surge];
  const double ahead_rate = course_.speed + w.rate[surge];
  State s;
  s.lla = course_.lla + angles(north(ahead, w.value[sway]), east(ahead, w.value[sway]), w.value[heave]);
  s.lla_rate = angles(north(ahead_rate, w.rate[sway]), east(ahead_rate, w.rate[sway]), w.rate[heave]);
  s.lla_acceleration = angles(north(w.acceleration[surge], w.acceleration[sway]),
                              east(w.acceleration[surge], w.acceleration[sway]), w.acceleration[heave]);
  s.euler << course_.roll + w.value[roll], course_.pitch + w.value[pitch], course_.heading + w.value[yaw];
  s.euler_rate << w.rate[roll], w.rate[pitch], w.rate[yaw];
  s.euler_acceleration << w.acceleration[roll], w.acceleration[pitch], w.acceleration[yaw];
  return s;
}

Motion motion(const State& state) {
  const Angle lat(state.lla[0]);
  Motion m = motion(state, lat, strapdown::radii(lat.sin, lat.cos));
  m.lla[1] = wrapped(m.lla[1]);
  m.roll_pitch_yaw[2] = wrapped(m.roll_pitch_yaw[2]);
  return m;
}

// v_s = v_m + ω_em × lever_arm, both turned from the navigation axes at the MINS into those at the point.
Point at_lever_arm(const State& state, const Vector3d& lever_arm) {
  const Motion m = motion(state);
  const Vector4d q_nm = strapdown::quaternion_from_euler(m.roll_pitch_yaw);
  if (lever_arm.isZero(0.0)) return {m.lla, m.v_n, q_nm};
  const Matrix3d C = strapdown::dcm_from_quaternion(q_nm);
  const Vector3d omega_in = frame_rate(state).omega - strapdown::omega_ie_n(state.lla[0]);
  const Vector3d omega_em = body_rate(state).omega + C.transpose() * omega_in;
  const Vector3d lla = position_at_lever_arm(state, C * lever_arm);
  const Vector4d q_sn = strapdown::quaternion_product(strapdown::quaternion_conjugate(q_en(lla[0], lla[1])),
                                                      q_en(state.lla[0], state.lla[1]));
  const Vector3d v = m.v_n + C * omega_em.cross(lever_arm);
  return {lla, strapdown::dcm_from_quaternion(q_sn) * v, strapdown::quaternion_product(q_sn, q_nm)};
}

// Of a rigid body a_s = a_m + ω̇ × lever_arm + ω × (ω × lever_arm) in inertial space; f = a − G, where the attraction G is gravity
// less the centrifugal acceleration: G(s) − G(m) = g(s) − g(m) + Ω × (Ω × lever_arm).
Inertial inertial_at_lever_arm(const State& state, const Vector3d& lever_arm) {
  const Angle lat(state.lla[0]);
  const strapdown::Radii radii = strapdown::radii(lat.sin, lat.cos);
  Inertial felt = simulation::inertial(motion(state, lat, radii), lat, radii);
  if (lever_arm.isZero(0.0)) return felt;
  const Matrix3d C = C_nm(state);
  const FrameRate frame = frame_rate(state), body = body_rate(state);
  const Vector3d omega_in_m = C.transpose() * frame.omega;
  const Vector3d omega_dot = body.derivative + C.transpose() * frame.derivative - body.omega.cross(omega_in_m);
  const Vector3d& omega = felt.omega_ib_b;

  const Vector3d lla = position_at_lever_arm(state, C * lever_arm);
  const Vector3d down_at_arm =
      -strapdown::C_en(state.lla[0], state.lla[1]).transpose() *
      Vector3d(std::cos(lla[0]) * std::cos(lla[1]), std::cos(lla[0]) * std::sin(lla[1]), std::sin(lla[0]));
  const Vector3d omega_ie = strapdown::omega_ie_n(state.lla[0]);
  Vector3d attraction =
      strapdown::gravity(lla[0], lla[2]).down * down_at_arm + omega_ie.cross(omega_ie.cross(C * lever_arm));
  attraction[2] -= strapdown::gravity(state.lla[0], state.lla[2]).down;
  felt.f_b += omega_dot.cross(lever_arm) + omega.cross(omega.cross(lever_arm)) - C.transpose() * attraction;
  return felt;
}

Vector4d inertial_attitude(const State& s, double t) {
  return strapdown::quaternion_product(q_en(s.lla[0], s.lla[1] + strapdown::wgs84::omega_ie * t),
                                       strapdown::quaternion_from_euler(s.euler));
}

}  // namespace binnacle::ship_simulator
