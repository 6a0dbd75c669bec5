// SPDX-License-Identifier: Apache-2.0
// A ship's motion in closed form, and what a perfect inertial sensor mounted upright on it measures.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "binnacle/process_model.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::test {

/// Paper 000, section 4: 5 m/s ahead, roll and pitch of three tones each, surge, sway and heave; no yaw. Latitude,
/// longitude and height are given, velocity is their exact derivative on the ellipsoid.
class Voyage {
 public:
  using Vector3d = Eigen::Vector3d;
  using Vector4d = Eigen::Vector4d;

  /// mounting: rotation vector of the slave against nominal, in the master's axes.
  explicit Voyage(const Vector3d& mounting = {0.012, -0.017, 0.02})
      : q_SM_(strapdown::attitude_plus(strapdown::quaternion_from_euler({0, 90 * degree, 0}), mounting)) {}

  /// The slave: attitude of its own, upright axes.
  strapdown::Navigation at(double t) const {
    const Vector3d lla = position(t), lla_rate = position_rate(t);
    const strapdown::Radii radii = strapdown::radii(lla[0]);
    const Vector3d v{(radii.meridian + lla[2]) * lla_rate[0],
                     (radii.transverse + lla[2]) * std::cos(lla[0]) * lla_rate[1], -lla_rate[2]};
    return {lla, v, strapdown::quaternion_product(strapdown::quaternion_from_euler(master_angles(t)), q_SM_)};
  }
  Vector3d master_angles(double t) const {
    return {tones(t, {0.07, 0.075, 0.08}, 0.2 * degree / 3, 0), tones(t, {0.11, 0.165, 0.22}, 0.04 * degree / 3, 1),
            heading};
  }
  const Vector4d& mounting() const { return q_SM_; }

  /// Body to inertial axes that stand where the earth's stood at t = 0.
  Vector4d inertial_attitude(double t) const {
    const strapdown::Navigation now = at(t);
    const Vector4d longitude = strapdown::quaternion_exp({0, 0, now.lla[1] + strapdown::wgs84::omega_ie * t});
    const Vector4d latitude = strapdown::quaternion_exp({0, -now.lla[0] - 90 * degree, 0});
    return product(product(longitude, latitude), now.q_nb);
  }
  /// The body's turn from t0 to t1 as a rotation vector in body axes.
  Vector3d turn(double t0, double t1) const {
    return strapdown::quaternion_log(
        product(strapdown::quaternion_conjugate(inertial_attitude(t0)), inertial_attitude(t1)));
  }
  Vector3d rate(double t) const {
    constexpr double h = 1e-4;
    return turn(t - h, t + h) / (2 * h);
  }
  Vector3d specific_force(double t) const {
    constexpr double h = 1e-2;
    const auto v = [this](double time) { return at(time).v_n; };
    const Vector3d v_rate =
        (45 * (v(t + h) - v(t - h)) - 9 * (v(t + 2 * h) - v(t - 2 * h)) + (v(t + 3 * h) - v(t - 3 * h))) / (60 * h);
    const strapdown::Navigation now = at(t);
    Vector3d f =
        v_rate +
        (2 * strapdown::omega_ie_n(now.lla[0]) + strapdown::omega_en_n(now.lla[0], now.lla[2], now.v_n)).cross(now.v_n);
    f[2] -= strapdown::gravity(now.lla[0], now.lla[2]).down;
    return strapdown::dcm_from_quaternion(now.q_nb).transpose() * f;
  }

 private:
  static constexpr double degree = M_PI / 180, heading = 0.7;

  static Vector4d product(const Vector4d& q, const Vector4d& p) { return strapdown::quaternion_product(q, p); }
  static double phase(std::size_t tone, int which) { return 1.3 * static_cast<double>(tone) + 2.1 * which + 0.4; }
  /// Three equal tones (Hz) with phases of their own.
  static double tones(double t, const std::array<double, 3>& hertz, double amplitude, int which) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += amplitude * std::sin(2 * M_PI * hertz[i] * t + phase(i, which));
    return sum;
  }
  static double tones_rate(double t, const std::array<double, 3>& hertz, double amplitude, int which) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double omega = 2 * M_PI * hertz[i];
      sum += amplitude * omega * std::cos(omega * t + phase(i, which));
    }
    return sum;
  }
  static constexpr std::array<double, 3> waves{0.09, 0.12, 0.15};
  static Vector3d position(double t) {
    const double ahead = 5 * t + tones(t, waves, 0.2, 2), right = tones(t, waves, 0.2, 3);
    return {0.63 + (ahead * std::cos(heading) - right * std::sin(heading)) / earth,
            2.2 + (ahead * std::sin(heading) + right * std::cos(heading)) / earth, 20 + tones(t, waves, 0.3, 4)};
  }
  static Vector3d position_rate(double t) {
    const double ahead = 5 + tones_rate(t, waves, 0.2, 2), right = tones_rate(t, waves, 0.2, 3);
    return {(ahead * std::cos(heading) - right * std::sin(heading)) / earth,
            (ahead * std::sin(heading) + right * std::cos(heading)) / earth, tones_rate(t, waves, 0.3, 4)};
  }
  static constexpr double earth = 6.37e6;

  Vector4d q_SM_;
};

/// Increments of a perfect sensor, one step each.
class VoyageSamples {
 public:
  enum class Increments { rotation_vectors, integrals };

  VoyageSamples(const Voyage& voyage, double duration, double dt, Increments increments) {
    const auto count = static_cast<std::size_t>(std::lround(duration / dt));
    fields_.resize(count), samples_.resize(count), steps_.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      const double t0 = static_cast<double>(k) * dt, t1 = static_cast<double>(k + 1) * dt;
      const auto integral = [&](const std::function<Eigen::Vector3d(double)>& f) -> Eigen::Vector3d {
        const double middle = 0.5 * (t0 + t1), off = 0.5 * dt * std::sqrt(0.6);
        return dt / 18 * (5 * f(middle - off) + 8 * f(middle) + 5 * f(middle + off));
      };
      const Eigen::Vector3d dtheta = increments == Increments::rotation_vectors
                                         ? voyage.turn(t0, t1)
                                         : integral([&](double t) { return voyage.rate(t); });
      const Eigen::Vector3d dv = integral([&](double t) { return voyage.specific_force(t); });
      fields_[k] = {dtheta[0], dtheta[1], dtheta[2], dv[0], dv[1], dv[2]};
      InputSample& sample = samples_[k];
      sample.t0 = sample.whole_t0 = nanoseconds(t0), sample.t1 = sample.whole_t1 = nanoseconds(t1);
      sample.dt = dt, sample.fields = fields_[k].data();
      steps_[k].t0 = sample.t0, steps_[k].t1 = sample.t1, steps_[k].dt = dt, steps_[k].samples = {&sample, 1};
    }
  }
  VoyageSamples(const VoyageSamples&) = delete;
  VoyageSamples& operator=(const VoyageSamples&) = delete;

  const std::vector<Step>& steps() const { return steps_; }

 private:
  std::vector<std::array<double, 6>> fields_;
  std::vector<InputSample> samples_;
  std::vector<Step> steps_;
};

}  // namespace binnacle::test
