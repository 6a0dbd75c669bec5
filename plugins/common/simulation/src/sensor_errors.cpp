// SPDX-License-Identifier: Apache-2.0
// The errors of a triad of inertial sensors.
#include "simulation/sensor_errors.hpp"

#include <cmath>

#include "binnacle/eigen.hpp"
#include "random/normal.hpp"
#include "simulation/fields.hpp"

namespace binnacle::simulation {

namespace {

using Vector = Eigen::Map<Eigen::Vector3d>;
using ConstVector = Eigen::Map<const Eigen::Vector3d>;

Eigen::Vector3d next_drift(const SensorModel& model, const Eigen::Vector3d& drift, double dt, random::Philox& stream) {
  const double kept = std::exp(-dt / model.tau);
  const double fresh = std::sqrt(-std::expm1(-2.0 * dt / model.tau));
  return kept * drift + fresh * model.instability.cwiseProduct(normal_vector(stream));
}

}  // namespace

Eigen::Vector3d normal_vector(random::Philox& stream) {
  const auto w = random::normal3(stream);
  return {w[0], w[1], w[2]};
}

Eigen::Vector3d first_normal_vector(std::uint64_t seed, std::string_view name) {
  auto stream = random::stream(seed, name);
  return normal_vector(stream);
}

SensorState start(const SensorModel& model, std::string_view name, std::uint64_t seed, double dt) {
  const std::string prefix(name);
  SensorState state{};
  Vector(state.bias) = model.bias.cwiseProduct(first_normal_vector(seed, prefix + ".bias"));
  Vector(state.scale) = model.scale.cwiseProduct(first_normal_vector(seed, prefix + ".scale"));
  auto misalignment_stream = random::stream(seed, prefix + ".misalignment");
  for (double& element : state.off_axis) element = model.misalignment * random::normal(misalignment_stream);
  state.drift_stream = random::stream(seed, prefix + ".instability");
  state.noise_stream = random::stream(seed, prefix + ".noise");
  Vector(state.drift_end) = model.instability.cwiseProduct(normal_vector(state.drift_stream));
  advance(model, state, dt);
  return state;
}

Eigen::Vector3d measured(const SensorModel& model, SensorState& state, const Eigen::Vector3d& increment, double dt) {
  const Eigen::Vector3d scale = ConstVector(state.scale);
  const Eigen::Vector3d noise = std::sqrt(dt) * model.noise.cwiseProduct(normal_vector(state.noise_stream));
  const double* n = state.off_axis;
  const Eigen::Vector3d off_axis(n[0] * increment[1] + n[1] * increment[2], n[2] * increment[0] + n[3] * increment[2],
                                 n[4] * increment[0] + n[5] * increment[1]);
  return increment + scale.cwiseProduct(increment) + off_axis + dt * bias_at(state, 0.5) + noise;
}

void advance(const SensorModel& model, SensorState& state, double dt) {
  if (model.instability.isZero(0.0)) return;
  const Eigen::Vector3d now = ConstVector(state.drift_end);
  Vector(state.drift_begin) = now;
  Vector(state.drift_end) = next_drift(model, now, dt, state.drift_stream);
}

Eigen::Vector3d bias_at(const SensorState& state, double fraction) {
  return ConstVector(state.bias) + (1.0 - fraction) * ConstVector(state.drift_begin) +
         fraction * ConstVector(state.drift_end);
}

std::vector<ParameterSpec> sensor_members(const std::string& unit, const std::string& noise_unit,
                                          const SensorDefaults& defaults) {
  using namespace parameter;
  return {
      sigmas("bias", unit, defaults.bias, "standard deviation of the bias, drawn once per run, per body axis"),
      sigmas("bias_instability", unit, defaults.instability,
             "standard deviation of the time-varying bias, a first-order Gauss-Markov process"),
      time("tau").above(0).defaults(defaults.tau).about("correlation time of the time-varying bias"),
      vector("noise", noise_unit, 3)
          .at_least(0)
          .defaults(defaults.noise)
          .about("root of the power spectral density of the white noise, the random walk of its integral"),
      sigmas("scale", "1", defaults.scale, "standard deviation of the scale factor error, drawn once per run"),
  };
}

SensorModel read_sensor(const Parameters& parameters) {
  return {parameters.vector("bias"),       parameters.vector("bias_instability"),
          seconds(parameters.time("tau")), parameters.vector("noise"),
          parameters.vector("scale"),      0.0};
}

}  // namespace binnacle::simulation
