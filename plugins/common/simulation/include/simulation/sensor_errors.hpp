// SPDX-License-Identifier: Apache-2.0
// The errors of a triad of inertial sensors: what they are, and their state in plain memory.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "random/philox.hpp"

namespace binnacle::simulation {

/// Per body axis, in SI; X is rad/s for gyroscopes and m/s² for accelerometers.
///     x_measured = (I + S + N) x + b + g(t) + n(t)
/// S = diag(s), s and b: constant over a run, N(0, scale²) and N(0, bias²); N: six off-diagonal elements, the axes that
/// are not where they should be, constant over a run, N(0, misalignment²); g: first-order Gauss–Markov process of
/// standard deviation `instability` and correlation time `tau`, stationary from the start; n: white noise of density
/// `noise`.
struct SensorModel {
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();         // X
  Eigen::Vector3d instability = Eigen::Vector3d::Zero();  // X
  double tau = 1.0;                                       // s
  Eigen::Vector3d noise = Eigen::Vector3d::Zero();        // X √s = X/√Hz
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();        // 1
  double misalignment = 0.0;                              // rad
};

/// Plain memory; all of it changes only through the functions below.
struct SensorState {
  double bias[3];
  double scale[3];
  double off_axis[6];     // N: xy xz yx yz zx zy
  double drift_begin[3];  // g at the begin of the interval that comes next
  double drift_end[3];    // and at its end
  random::Philox drift_stream;
  random::Philox noise_stream;
};

/// Draws s, b, N and g(0), and g at the end of the first interval, from the streams "NAME.bias", "NAME.scale",
/// "NAME.misalignment", "NAME.instability" and "NAME.noise" of the seed. Each error has its own stream and unit deviates are drawn
/// whatever their size, so no parameter changes the draws of another error or axis.
SensorState start(const SensorModel& model, std::string_view name, std::uint64_t seed, double dt);

/// The increment over the next interval as the triad measures it, from the true one. Over an interval the
/// drift is the mean of its two ends: what that leaves out has a variance of instability² dt/(6 tau) of a
/// rate.
Eigen::Vector3d measured(const SensorModel& model, SensorState& state, const Eigen::Vector3d& increment, double dt);

/// Moves the drift on to the following interval:  g(t + dt) = e^(−dt/tau) g(t) + instability √(1 − e^(−2
/// dt/tau)) w.  Where no axis wanders nothing is drawn.
void advance(const SensorModel& model, SensorState& state, double dt);

/// b + g at a fraction (0 … 1) of the interval that comes next.
Eigen::Vector3d bias_at(const SensorState& state, double fraction);

/// The parameters of one triad and how they are read. `unit` is X's; defaults are config texts.
struct SensorDefaults {
  std::string bias, instability, tau, noise, scale;
};
std::vector<ParameterSpec> sensor_members(const std::string& unit, const std::string& noise_unit,
                                          const SensorDefaults& defaults);
SensorModel read_sensor(const Parameters& parameters);

/// Three independent deviates of N(0, 1).
Eigen::Vector3d normal_vector(random::Philox& stream);
/// The first three of the stream called `name` of `seed`.
Eigen::Vector3d first_normal_vector(std::uint64_t seed, std::string_view name);

}  // namespace binnacle::simulation
