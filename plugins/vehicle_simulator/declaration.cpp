// SPDX-License-Identifier: Apache-2.0
// What the simulator declares: its parameters and its channels.
#include "declaration.hpp"

#include <string>
#include <utility>

#include "body_parameters.hpp"
#include "segments.hpp"
#include "simulation/sensor_errors.hpp"

namespace binnacle::vehicle_simulator {

namespace {

using namespace simulation;

Triad deviation_fields(const std::string& quantity, const std::string& unit) {
  const std::string text = "standard deviation that the receiver states for its " + quantity + ", ";
  return {level(quantity + "_sd_n", unit, text + "north"), level(quantity + "_sd_e", unit, text + "east"),
          level(quantity + "_sd_d", unit, text + "down")};
}

std::vector<ParameterSpec> start_members() {
  using namespace parameter;
  return {
      number("lat", "rad").at_least(-89.0 * degree).at_most(89.0 * degree).required().about("geodetic latitude"),
      number("lon", "rad").defaults("0").about("longitude"),
      number("height", "m").defaults("0").about("height above the ellipsoid"),
      number("heading", "rad").defaults("0").about("heading, clockwise from north"),
      number("speed", "m/s").at_least(0).defaults("0").about("speed at the start"),
  };
}

std::vector<ParameterSpec> gnss_members() {
  using namespace parameter;
  return {
      sigmas("position_sigma", "m", "[1.5, 1.5, 3]",
             "standard deviation of the white position error: north, east, down"),
      sigmas("velocity_sigma", "m/s", "[0.05, 0.05, 0.1]",
             "standard deviation of the white velocity error: north, east, down"),
      vector("reported_position_sigma", "m", 3)
          .at_least(0)
          .about("reported standard deviations position_sd_*; default: position_sigma"),
      vector("reported_velocity_sigma", "m/s", 3)
          .at_least(0)
          .about("reported standard deviations velocity_sd_*; default: velocity_sigma"),
      vector("lever_arm", "m", 3)
          .formerly("arm")
          .defaults("[0, 0, 0]")
          .about("lever arm from the IMU to the antenna, body axes"),
  };
}

std::vector<ParameterSpec> initial_members() {
  using namespace parameter;
  return {
      sigmas("position", "m", "[1.5, 1.5, 3]", "position error: north, east, down"),
      sigmas("velocity", "m/s", "[0.05, 0.05, 0.05]", "velocity error: north, east, down"),
      number("tilt", "rad").at_least(0).defaults("\"0.1 deg\"").about("attitude error about north and about east"),
      number("heading", "rad").at_least(0).defaults("\"1 deg\"").about("attitude error about down"),
  };
}

SensorDefaults gyro_defaults() {
  return {"\"100 deg/h\"", "\"5 deg/h\"", "\"300 s\"", "\"0.3 deg/sqrt(h)\"", "\"300 ppm\""};
}

SensorDefaults accel_defaults() {
  return {"\"3 mg\"", "\"0.05 mg\"", "\"300 s\"", "\"0.03 m/s/sqrt(h)\"", "\"300 ppm\""};
}

std::vector<ParameterSpec> component_parameters() {
  using namespace parameter;
  std::vector<ParameterSpec> parameters = {
      object("start", start_members()).required().about("initial position and motion of the vehicle"),
      time("start_time").defaults("0").about("start time on the run's clock"),
      list("segments", object("segment", segment_members()))
          .required()
          .about("sequence of manoeuvres; the README lists the keys of each"),
      integer("repeat").at_least(1).at_most(10000).defaults("1").about(
          "number of times the list of segments is driven"),
      time("ramp").at_least(0.01).defaults("\"2 s\"").about(
          "time in which a manoeuvre builds up and fades out, at most half of its duration"),
      number("roll_gradient", "rad*s^2/m")
          .defaults("0")
          .about("roll out of the turn per lateral acceleration; a car: \"4 deg/g\""),
      number("pitch_gradient", "rad*s^2/m")
          .defaults("0")
          .about("pitch up per acceleration along the path; a car: \"1.5 deg/g\""),
      number("imu_rate", "Hz").at_least(1).at_most(1e5).defaults("200").about("sample rate of the channel imu"),
      choice("imu_kind", {"increment", "rate"})
          .defaults("\"increment\"")
          .about("content of imu: integrals over the interval, or means"),
      number("gnss_rate", "Hz")
          .at_least(0)
          .at_most(1000)
          .defaults("1")
          .about("rate of fixes, the first at the start; 0: none"),
      number("truth_rate", "Hz")
          .at_least(0)
          .at_most(1e5)
          .defaults("10")
          .about("rate of truth samples, the first at the start; 0: none"),
      boolean("perfect").defaults("false").about(
          "true: no errors; the reported standard deviations and covariance do not change"),
      object("gyro", sensor_members("rad/s", "rad/sqrt(s)", gyro_defaults()))
          .defaults("{}")
          .about("errors of the gyroscopes"),
      object("accel", sensor_members("m/s^2", "m/s/sqrt(s)", accel_defaults()))
          .defaults("{}")
          .about("errors of the accelerometers"),
      object("gnss", gnss_members()).defaults("{}").about("errors of the fixes, and position of the antenna"),
      object("initial_sigma", initial_members())
          .defaults("{}")
          .about("standard deviations of the estimate on the channel initial, from which its errors are drawn"),
  };
  for (ParameterSpec& parameter : body_parameters()) parameters.push_back(std::move(parameter));
  return parameters;
}

}  // namespace

ComponentSpec declare_component() {
  ComponentSpec spec;
  spec.type = "vehicle_simulator";
  spec.summary = "A drive made of segments: IMU samples, GNSS fixes, truth and an initial estimate";
  spec.source =
      "P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., "
      "(5.53), (5.41), (2.22) and (2.58), solved for specific force and angular rate";
  spec.parameters = component_parameters();
  spec.example = R"json({
  "start": { "lat": "48.1 deg", "lon": "11.6 deg", "height": "520 m", "heading": "30 deg" },
  "segments": [
    { "do": "still", "duration": "20 s" },
    { "do": "accelerate", "to": "15 m/s", "acceleration": "1.5 m/s^2" },
    { "do": "turn", "angle": "90 deg", "rate": "12 deg/s" },
    { "do": "climb", "height": "8 m", "duration": "20 s" },
    { "do": "straight", "duration": "30 s" },
    { "do": "accelerate", "to": 0, "acceleration": "-2 m/s^2" },
    { "do": "still", "duration": "10 s" }
  ],
  "imu_rate": "100 Hz",
  "gyro": { "bias": "100 deg/h", "noise": "0.3 deg/sqrt(h)" }
})json";
  return spec;
}

Channels declare_channels(SourceDeclaration& declaration, bool emits_rates, Time imu_interval) {
  Channels handles;
  ChannelDeclaration imu("imu"), gnss("gnss"), truth("truth"), initial("initial");
  static_cast<ImuFields&>(handles.imu) = carry_imu(imu, emits_rates);
  imu.max_interval = imu_interval;
  handles.gnss.position = gnss.carries(position_fields());
  handles.gnss.velocity = gnss.carries(velocity_fields());
  handles.gnss.position_sd = gnss.carries(deviation_fields("position", "m"));
  handles.gnss.velocity_sd = gnss.carries(deviation_fields("velocity", "m/s"));
  auto& t = handles.truth;
  t.position = truth.carries(position_fields());
  t.velocity = truth.carries(velocity_fields());
  t.attitude = truth.carries(attitude_fields());
  t.gyro_bias = truth.carries(triad("bg", "rad/s", "bias of the gyroscopes, constant and wandering part together"));
  t.accel_bias =
      truth.carries(triad("ba", "m/s^2", "bias of the accelerometers, constant and wandering part together"));
  t.gyro_scale = truth.carries(triad("sg", "1", "scale factor error of the gyroscopes"));
  t.accel_scale = truth.carries(triad("sa", "1", "scale factor error of the accelerometers"));
  t.misalignment =
      truth.carries(level("mount_x", "rad", "misalignment of the IMU in the vehicle, about the vehicle's x"),
                    level("mount_y", "rad", "about its y"), level("mount_z", "rad", "about its z"));
  t.speed = truth.carries(level("speed", "m/s", "along the path"));
  t.standing = truth.carries(level("standing", "1", "1 at a speed of zero, else 0"));
  t.rates = truth.carries(triad("omega_", "rad/s", "angular rate against inertial space, without shaking"));
  handles.initial.position = initial.carries(position_fields());
  handles.initial.velocity = initial.carries(velocity_fields());
  handles.initial.attitude = initial.carries(attitude_fields());
  initial.covariance = navigation_covariance();
  handles.imu.channel = declaration.emits(std::move(imu));
  handles.gnss.channel = declaration.emits(std::move(gnss));
  handles.truth.channel = declaration.emits(std::move(truth));
  handles.initial.channel = declaration.emits(std::move(initial));
  return handles;
}

}  // namespace binnacle::vehicle_simulator
