// SPDX-License-Identifier: Apache-2.0
// A simulated drive for tests: the vehicle simulator with parameters from JSON, sample by sample.
#pragma once

#include <numbers>
#include <vector>

#include "simulation.hpp"
#include "strapdown/earth.hpp"
#include "vehicle_simulator/simulator.hpp"

namespace binnacle::simulated_drive {

using namespace binnacle::vehicle_simulator;
using Eigen::Vector3d;
using namespace binnacle::simulation;
using Drive = Simulation<VehicleSimulator>;

inline Trajectory trajectory_of(const Json& config) {
  const ParameterValue value = checked<VehicleSimulator>(config);
  const Parameters p(value);
  const Parameters start = p.object("start");
  return Trajectory({{start.number("lat"), start.number("lon"), start.number("height")}}, read_segments(p),
                    {p.number("roll_gradient"), p.number("pitch_gradient")});
}

// ---- drives

inline const Json munich = {{"lat", "48.1 deg"}, {"lon", "11.6 deg"}, {"height", "520 m"}, {"heading", "30 deg"}};

inline Json lively_segments() {
  return Json::parse(R"([
    {"do": "still", "duration": "6 s"},
    {"do": "accelerate", "to": "14 m/s", "acceleration": "1.8 m/s^2"},
    {"do": "turn", "angle": "95 deg", "rate": "15 deg/s"},
    {"do": "straight", "duration": "5 s"},
    {"do": "climb", "height": "6 m", "duration": "12 s"},
    {"do": "turn", "angle": "-200 deg", "duration": "14 s"},
    {"do": "accelerate", "to": "22 m/s", "duration": "9 s"},
    {"do": "climb", "slope": "-4 deg", "duration": "7 s"},
    {"do": "accelerate", "to": 0, "acceleration": "-2.5 m/s^2"},
    {"do": "still", "duration": "3 s"}])");
}

inline Json lively_drive(int repeat) {
  return {{"start", munich},
          {"segments", lively_segments()},
          {"repeat", repeat},
          {"perfect", true},
          {"roll_gradient", "4 deg/g"},
          {"pitch_gradient", "1.5 deg/g"},
          {"gnss_rate", 1},
          {"truth_rate", 1}};
}

inline Json standing(double seconds_long) {
  return {{"start", munich}, {"segments", Json::array({{{"do", "still"}, {"duration", seconds_long}}})}};
}

inline double metres(const Vector3d& lla, const Vector3d& from) { return strapdown::position_minus(lla, from).norm(); }

}  // namespace binnacle::simulated_drive
