// SPDX-License-Identifier: Apache-2.0
// Attitude of a moving IMU from velocities over a window, whatever the attitude is.
//
// With b0 the body axes at the begin, held against inertial space, and n the navigation axes (north, east, down),
//     v(t) = c + g t + C_nb0 a(t) ,  a(t) = ∫ C_b0b f dt ,
// so velocities and integrated specific forces are two sets of vectors that a rotation takes into each other: Wahba's
// problem (Wu, Pan, Velocity/position integration formula part I: application to in-flight coarse alignment, IEEE Trans.
// AES 49, 2013, eq. 11 to 22). Its solution needs no first guess. Then biases of the sensors join it in a least squares
// fit. The rotation of n and the Coriolis acceleration are left out: in 20 s they turn g by 1.5e-3 rad.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "binnacle/time.hpp"

namespace binnacle::in_motion_alignment {

/// Of the IMU's samples from one epoch to the next, with C from body axes to those at its begin (Forster et al., On-manifold
/// preintegration, IEEE Trans. Robotics 33, 2017).
struct Integrals {
  double q[4] = {1, 0, 0, 0};  // of C
  double force[3] = {};        // ∫ C f dt
  double axes[9] = {};         // M = ∫ C dt, column-major: of an accelerometer bias
  double turned[9] = {};       // N = ∫ [C f]× M dt: of a gyro bias

  void add(double dt, const Eigen::Vector3d& rate, const Eigen::Vector3d& specific_force);
};

struct Epoch {
  Time t = no_time;
  double velocity[3] = {};  // m/s, north, east, down
  double variance = 0;      // (m/s)², per axis
  Integrals since_last;
};

struct Priors {
  double accelerometer_bias = 0, gyro_bias = 0;  // 1-sigma per axis, m/s² and rad/s
};

/// The x axis points where a vehicle drives to: its newest velocity, where that is fast enough to have a direction.
struct Course {
  double sd = 0;         // rad, of the x axis in pitch and in yaw; 0: nothing is known of it
  double min_speed = 0;  // m/s
};

struct Fit {
  bool is_found = false;
  Eigen::Vector4d q_nb;       // at the last epoch
  Eigen::Matrix3d P;          // of φ, q_true = exp(φ) ⊗ q_nb
  Eigen::Vector3d gyro_bias;  // rad/s
  Eigen::Matrix3d P_gyro_bias;
  double misfit = 0;  // RMS of residuals over their 1-sigma
};

class Chain;

/// The newest epochs. Plain memory.
class Window {
 public:
  static constexpr std::size_t capacity = 64;

  void clear() { count_ = first_ = 0; }
  /// Drops what is older than `length` before it.
  void add(const Epoch& epoch, Time length);
  std::size_t count() const { return count_; }
  Time newest() const { return count_ > 0 ? at(count_ - 1).t : no_time; }
  /// Of so many epochs.
  Window newest(std::size_t count) const;
  Time span() const { return count_ > 0 ? at(count_ - 1).t - at(0).t : 0; }
  Fit fit(const Priors& priors) const;
  /// The same from a few epochs, with the help of the course. Not found below the course's least speed.
  Fit fit(const Priors& priors, const Course& course) const;

 private:
  const Epoch& at(std::size_t i) const { return epochs_[(first_ + i) % capacity]; }
  template <class Use>
  void for_each(Chain& chain, Use&& use) const;
  Eigen::Matrix3d rotation() const;
  Eigen::Matrix3d rotation_by_course() const;
  Fit fit_from(Eigen::Matrix3d C, const Priors& priors, const Course& course) const;

  std::array<Epoch, capacity> epochs_{};
  std::uint64_t first_ = 0, count_ = 0;
};

}  // namespace binnacle::in_motion_alignment
