// SPDX-License-Identifier: Apache-2.0
// What the simulator declares: its parameters and its channels.
#include "declaration.hpp"

#include <numbers>
#include <string>
#include <utility>

#include "waves.hpp"

namespace binnacle::ship_simulator {

namespace {

using namespace simulation;

constexpr double degree = std::numbers::pi / 180.0;

/// The attitude of axes that are fixed in the SINS and would be those of the ship if the mounting were the nominal one.
/// Where the SINS stands upright its own roll and yaw are ill conditioned; these are not.
Triad level_attitude_fields() {
  return {level("level_roll", "rad", "roll of the SINS turned back by the nominal mounting"),
          level("level_pitch", "rad", "pitch of the SINS turned back by the nominal mounting"),
          level("level_yaw", "rad", "yaw of the SINS turned back by the nominal mounting")};
}

Channels::State carry_state(ChannelDeclaration& channel) {
  Channels::State handles;
  handles.position = channel.carries(position_fields());
  handles.velocity = channel.carries(velocity_fields());
  handles.attitude = channel.carries(attitude_fields());
  handles.level_attitude = channel.carries(level_attitude_fields());
  return handles;
}

std::vector<ParameterSpec> start_members() {
  using namespace parameter;
  return {
      number("lat", "rad").at_least(-80.0 * degree).at_most(80.0 * degree).required().about("geodetic latitude"),
      number("lon", "rad").defaults("0").about("longitude"),
      number("height", "m").defaults("0").about("height above the ellipsoid"),
      number("heading", "rad").defaults("0").about("mean heading and course, from north to east"),
      number("speed", "m/s").at_least(0).defaults("5").about("speed ahead"),
      number("roll", "rad").defaults("0").about("mean roll: the list"),
      number("pitch", "rad").defaults("0").about("mean pitch: the trim"),
  };
}

/// Paper 000, section 4: roll 0.07 to 0.08 Hz, 0.2° at most; pitch 0.11 to 0.22 Hz, 0.04°; no yaw; some surge, sway, heave.
std::vector<ParameterSpec> motion_members() {
  constexpr std::array<const char*, freedoms> defaults = {
      R"({"tones": [{"amplitude": "0.066666666666666667 deg", "frequency": 0.07},
                    {"amplitude": "0.066666666666666667 deg", "frequency": 0.075},
                    {"amplitude": "0.066666666666666667 deg", "frequency": 0.08}]})",
      R"({"tones": [{"amplitude": "0.013333333333333333 deg", "frequency": 0.11},
                    {"amplitude": "0.013333333333333333 deg", "frequency": 0.165},
                    {"amplitude": "0.013333333333333333 deg", "frequency": 0.22}]})",
      "{}",
      R"({"tones": [{"amplitude": "0.1 m", "frequency": 0.1}]})",
      R"({"tones": [{"amplitude": "0.1 m", "frequency": 0.08}]})",
      R"({"tones": [{"amplitude": "0.2 m", "frequency": 0.12}]})"};
  constexpr std::array<const char*, freedoms> texts = {"roll, right side down positive", "pitch, nose up positive",
                                                       "angle, positive to the right",   "displacement ahead",
                                                       "displacement to the right",      "displacement down"};
  std::vector<ParameterSpec> members;
  for (std::size_t k = 0; k < freedoms; ++k)
    members.push_back(parameter::object(freedom_name[k], freedom_members(k < surge ? "rad" : "m"))
                          .defaults(defaults[k])
                          .about(texts[k]));
  return members;
}

std::vector<ParameterSpec> mounting_members() {
  using namespace parameter;
  return {
      matrix("nominal", "1", 3, 3)
          .defaults("[[0, 0, 1], [0, 1, 0], [-1, 0, 0]]")
          .about("nominal C_S^M: SINS axes to MINS axes; default: upright"),
      sigmas("misalignment_sigma", "rad", "[\"1 deg\", \"1 deg\", \"1 deg\"]",
             "standard deviation of the misalignment, drawn once per run, about MINS axes"),
      vector("misalignment", "rad", 3).about("fixed misalignment, the same in every run; default: drawn"),
      vector("lever_arm", "m", 3)
          .formerly("arm")
          .defaults("[0, 0, 0]")
          .about("lever arm from the MINS to the SINS, MINS axes"),
  };
}

std::vector<ParameterSpec> sensor_members(const std::string& unit, const std::string& bias, const std::string& noise) {
  using namespace parameter;
  return {
      sigmas("bias", unit, bias, "standard deviation of the bias, drawn once per run"),
      sigmas("scale", "1", "\"200 ppm\"", "standard deviation of the scale factor error, drawn once per run"),
      number("misalignment", "rad")
          .at_least(0)
          .defaults("\"1 arcmin\"")
          .about("standard deviation of the misalignment of each axis towards each other axis, drawn once per run"),
      sigmas("noise", unit, noise, "standard deviation of the rate noise over noise_time"),
      number("noise_time", "s")
          .above(0)
          .defaults("0.1")
          .about("averaging time of noise: white noise of power spectral density noise^2 * noise_time"),
  };
}

std::vector<ParameterSpec> mins_members() {
  using namespace parameter;
  return {
      number("rate", "Hz")
          .at_least(0)
          .at_most(1000)
          .defaults("5")
          .about("sample rate of the MINS, the first sample after one interval; 0: none"),
      sigmas("velocity_noise", "m/s", "0.257", "standard deviation of the white velocity error: north, east, down"),
      sigmas("attitude_noise", "rad", "\"0.2 arcmin\"",
             "standard deviation of the white attitude error: roll, pitch, yaw"),
      sigmas("position_noise", "m", "0", "standard deviation of the white position error: north, east, down"),
      sigmas("velocity_bias", "m/s", "0", "standard deviation of a constant velocity error"),
      sigmas("attitude_bias", "rad", "[\"1 arcmin\", \"1 arcmin\", \"3 arcmin\"]",
             "standard deviation of the MINS' own alignment error: roll, pitch, yaw"),
      sigmas("position_bias", "m", "0", "standard deviation of a constant position error"),
      number("noise_scale", "1")
          .at_least(0)
          .defaults("1")
          .about("factor on the white errors, to make them differ from the noise in the filter"),
  };
}

std::vector<ParameterSpec> triple_members(const char* position, const char* velocity, const char* attitude) {
  using namespace parameter;
  return {
      sigmas("position", "m", position, "position: north, east, down"),
      sigmas("velocity", "m/s", velocity, "velocity: north, east, down"),
      sigmas("attitude", "rad", attitude, "attitude: about north, east, down"),
  };
}

std::vector<ParameterSpec> initial_members() {
  using namespace parameter;
  return {
      choice("from", {"mins", "truth"})
          .defaults("\"mins\"")
          .about("source of the estimate: the MINS, rotated by the nominal mounting (as in the paper), or the truth "
                 "with drawn errors"),
      object("error", triple_members("0", "0", "[\"1 arcmin\", \"1 arcmin\", \"3 arcmin\"]"))
          .defaults("{}")
          .about("standard deviations of the errors, drawn once per run, for \"from\": \"truth\""),
      object("sigma", triple_members("10", "0.257", "\"1 deg\""))
          .defaults("{}")
          .about("standard deviations of the emitted covariance, independent of the errors"),
  };
}

std::vector<ParameterSpec> component_parameters() {
  using namespace parameter;
  return {
      object("start", start_members()).required().about("initial position and course of the MINS"),
      time("start_time").defaults("0").about("start time on the run's clock"),
      time("duration").at_least(0.01).defaults("100").about("duration of the simulation"),
      object("motion", motion_members())
          .defaults("{}")
          .about("motion in waves; each degree of freedom by tones or by a spectrum"),
      object("mounting", mounting_members()).defaults("{}").about("mounting of the SINS"),
      number("imu_rate", "Hz")
          .at_least(1)
          .at_most(1e5)
          .defaults("100")
          .about("sample rate of the SINS' inertial sensors"),
      choice("increments", {"rate", "rotation_vector"})
          .defaults("\"rate\"")
          .about("meaning of wx wy wz: the integral of the angular rate, or the rotation vector, over the interval"),
      number("truth_rate", "Hz")
          .at_least(0)
          .at_most(1e5)
          .defaults("5")
          .about("rate of truth and mounting samples, the first at the start; 0: none"),
      boolean("perfect").defaults("false").about(
          "true: no errors of sensors, MINS and initial estimate; the misalignment remains"),
      object("gyro", sensor_members("rad/s", "\"0.2 deg/h\"", "\"10 deg/h\""))
          .defaults("{}")
          .about("errors of the SINS' gyroscopes"),
      object("accel", sensor_members("m/s^2", "\"200 ug\"", "\"1500 ug\""))
          .defaults("{}")
          .about("errors of the SINS' accelerometers"),
      object("mins", mins_members()).defaults("{}").about("the master and its errors"),
      object("initial", initial_members())
          .defaults("{}")
          .about("initial estimate of the SINS' state on the channel initial"),
  };
}

}  // namespace

ComponentSpec declare_component() {
  ComponentSpec spec;
  spec.type = "ship_simulator";
  spec.summary =
      "A ship in waves: a master INS, the inertial sensors of a slave INS, truth, mounting and an initial estimate";
  spec.source =
      "Park and Lee, SDINS transfer alignment using adaptive filter for vertical launcher (paper 000), section 4, "
      "tables 1 "
      "and 2";
  spec.parameters = component_parameters();
  spec.example = R"json({
  "start": { "lat": "36.4 deg", "lon": "127.4 deg", "heading": "30 deg", "speed": "5 m/s" },
  "duration": "100 s",
  "motion": {
    "roll": { "spectrum": { "omega": "0.5 rad/s", "zeta": 0.1, "sigma": "2 deg" } },
    "heave": { "tones": [{ "amplitude": "0.3 m", "frequency": "0.12 Hz" }] }
  },
  "mounting": { "misalignment_sigma": "1 deg", "lever_arm": ["3 m", 0, "-2 m"] },
  "mins": { "noise_scale": 1 }
})json";
  return spec;
}

Channels declare_channels(SourceDeclaration& declaration, Time imu_interval) {
  Channels handles;
  ChannelDeclaration imu("imu"), mins("mins"), truth("truth"), initial("initial"), mounting("mounting");
  static_cast<ImuFields&>(handles.imu) = carry_imu(imu, false);
  imu.max_interval = imu_interval;
  handles.mins.velocity = mins.carries(velocity_fields());
  handles.mins.position = mins.carries(position_fields());
  handles.mins.attitude = mins.carries(attitude_fields());
  handles.truth = carry_state(truth);
  handles.initial = carry_state(initial);
  initial.covariance = navigation_covariance();
  handles.mounting.misalignment = mounting.carries(level("mx", "rad", "misalignment about MINS x (forward)"),
                                                   level("my", "rad", "misalignment about MINS y (right)"),
                                                   level("mz", "rad", "misalignment about MINS z (down)"));
  handles.imu.channel = declaration.emits(std::move(imu));
  handles.mins.channel = declaration.emits(std::move(mins));
  handles.truth.channel = declaration.emits(std::move(truth));
  handles.initial.channel = declaration.emits(std::move(initial));
  handles.mounting.channel = declaration.emits(std::move(mounting));
  return handles;
}

}  // namespace binnacle::ship_simulator
