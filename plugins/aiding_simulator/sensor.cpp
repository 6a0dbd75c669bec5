// SPDX-License-Identifier: Apache-2.0
// What simulated sensors share.
#include "sensor.hpp"

#include <iterator>
#include <utility>

#include <Eigen/Geometry>

#include "strapdown/earth.hpp"

namespace binnacle::aiding_simulator {

std::vector<SensorKind> sensor_kinds() {
  std::vector<SensorKind> kinds;
  for (SensorKind (*const kind)() :
       {magnetometer, height, body_velocity, heading, course, attitude, range, range_difference})
    kinds.push_back(kind());
  return kinds;
}

ParameterSpec sensor_object(const char* name, std::vector<ParameterSpec> own, const char* text) {
  std::vector<ParameterSpec> members = {parameter::time("every").at_least(0).defaults("\"1 s\"").about(
      "time between measurements; the first is at the first sample of the input, each at one of its samples")};
  members.insert(members.end(), std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()));
  return parameter::object(name, std::move(members)).about(text);
}

ParameterSpec lever_arm_parameter() {
  return parameter::vector("lever_arm", "m", 3)
      .plausible(0, 100)
      .defaults("[0, 0, 0]")
      .about("lever arm from the point of the truth to the sensor, body axes");
}

void add_slow_error(std::vector<ParameterSpec>& to, const std::string& name, const std::string& unit,
                    const std::string& text) {
  using namespace parameter;
  to.push_back(number(name, unit).at_least(0).defaults("0").about("1-sigma of the " + text + ", drawn once per run"));
  to.push_back(number(name + "_wandering", unit)
                   .at_least(0)
                   .defaults("0")
                   .about("1-sigma of a time-varying bias, a first-order Gauss-Markov process"));
  to.push_back(time(name + "_tau").above(0).defaults("\"600 s\"").about("correlation time of the time-varying bias"));
}

SlowError read_slow_error(const Parameters& parameters, const std::string& name, std::string error, std::string unit,
                          std::string text) {
  return {std::move(error),
          std::move(unit),
          std::move(text),
          parameters.number(name),
          parameters.number(name + "_wandering"),
          seconds(parameters.time(name + "_tau"))};
}

Eigen::Vector3d position_at(const Truth& truth, const Eigen::Vector3d& lever_arm) {
  return lever_arm.isZero(0.0) ? truth.lla : strapdown::position_plus(truth.lla, truth.C_nb * lever_arm);
}

Eigen::Vector3d velocity_at(const Truth& truth, const Eigen::Vector3d& lever_arm) {
  if (lever_arm.isZero(0.0)) return truth.v_n;
  const Eigen::Vector3d omega_eb_b = truth.omega_ib_b - truth.C_nb.transpose() * strapdown::omega_ie_n(truth.lla[0]);
  return truth.v_n + truth.C_nb * omega_eb_b.cross(lever_arm);
}

}  // namespace binnacle::aiding_simulator
