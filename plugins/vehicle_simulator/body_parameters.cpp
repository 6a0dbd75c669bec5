// SPDX-License-Identifier: Apache-2.0
// The parameters of ride and body.
#include "body_parameters.hpp"

#include <numbers>
#include <string>
#include <utility>

#include "binnacle/eigen.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::vehicle_simulator {

namespace {

using namespace parameter;

ParameterSpec size(std::string name, std::string unit, std::string text) {
  return number(std::move(name), std::move(unit)).at_least(0).defaults("0").about(std::move(text));
}

ParameterSpec frequency(std::string hertz, std::string text) {
  return number("frequency", "Hz").at_least(0.01).at_most(1000).defaults(std::move(hertz)).about(std::move(text));
}

std::vector<ParameterSpec> ride_members() {
  return {size("slip", "rad*s^2/m", "side-slip angle per lateral acceleration, with the body pointing into the curve"),
          size("sway", "m/s", "lateral velocity, standard deviation at full speed"),
          size("heave", "m/s", "vertical velocity, standard deviation at full speed"),
          size("rocking", "m/s",
               "forward, right and down velocity of the standing vehicle, standard deviation of each"),
          size("roll", "rad", "roll relative to the path, standard deviation at full speed"),
          size("pitch", "rad", "pitch relative to the path, standard deviation at full speed"),
          frequency("1.5", "frequency at which sway, heave, roll and pitch are strongest"),
          number("half_speed", "m/s")
              .at_least(0.01)
              .defaults("1")
              .about("speed for the scaling of the motion by v / sqrt(v^2 + half_speed^2) at the speed v")};
}

std::vector<ParameterSpec> boarding_members() {
  return {time("every").at_least(0).defaults("0").about("time per disturbance during a stop; 0: no boarding"),
          time("after").at_least(0).defaults("0").about("time from the start before which nobody boards"),
          time("duration").at_least(0.05).defaults("1").about("duration of a disturbance"),
          size("heave", "m", "standard deviation of the disturbance in height, down and up again"),
          size("roll", "rad", "standard deviation of the disturbance in roll"),
          size("pitch", "rad", "standard deviation of the disturbance in pitch")};
}

std::vector<ParameterSpec> shake_members(const char* when) {
  return {size("accel", "m/s^2", std::string("root mean square per axis, ") + when),
          size("rate", "rad/s", std::string("root mean square per axis, ") + when)};
}

std::vector<ParameterSpec> shaking_members() {
  return {object("standing", shake_members("standing")).defaults("{}").about("vibration from the engine"),
          object("driving", shake_members("at full speed")).defaults("{}").about("vibration from engine and road"),
          frequency("25", "frequency at which the vibration is strongest")};
}

std::vector<ParameterSpec> mounting_members() {
  constexpr double turn = 2.0 * std::numbers::pi;
  const auto angle = [&](std::string name, std::string text) {
    return number(std::move(name), "rad").at_least(-turn).at_most(turn).defaults("0").about(std::move(text));
  };
  return {angle("roll", "nominal rotation from the IMU's to the vehicle's axes: about x, applied first"),
          angle("pitch", "rotation about y, applied second"), angle("yaw", "rotation about z, applied third"),
          vector("misalignment", "rad", 3)
              .at_least(-1)
              .at_most(1)
              .defaults("[0, 0, 0]")
              .about("unknown misalignment: zeta in vehicle axes, C_v^b = M' exp(-[zeta x])"),
          vector("misalignment_sigma", "rad", 3)
              .at_least(0)
              .at_most(1)
              .defaults("[0, 0, 0]")
              .about("standard deviation of an additional misalignment, drawn once per run")};
}

Shaking read_shaking(const Parameters& parameters) { return {parameters.number("accel"), parameters.number("rate")}; }

}  // namespace

std::vector<ParameterSpec> body_parameters() {
  return {object("ride", ride_members()).defaults("{}").about("motion of the body relative to the path; default: none"),
          object("boarding", boarding_members()).defaults("{}").about("disturbances by passengers who board at stops"),
          object("shaking", shaking_members()).defaults("{}").about("vibration of the sensor; default: none"),
          vector("lever_arm", "m", 3)
              .formerly("arm")
              .defaults("[0, 0, 0]")
              .about("lever arm from the point that follows the path, such as the rear axle, to the IMU, vehicle axes"),
          object("mounting", mounting_members()).defaults("{}").about("orientation of the IMU's axes in the vehicle")};
}

BodyModel read_body(const Parameters& parameters) {
  const Parameters ride = parameters.object("ride"), boarding = parameters.object("boarding"),
                   shaking = parameters.object("shaking"), mounting = parameters.object("mounting");
  BodyModel model;
  model.ride = {.slip = ride.number("slip"),
                .sway = ride.number("sway"),
                .heave = ride.number("heave"),
                .rocking = ride.number("rocking"),
                .roll = ride.number("roll"),
                .pitch = ride.number("pitch"),
                .frequency = ride.number("frequency"),
                .half_speed = ride.number("half_speed"),
                .boarding_every = seconds(boarding.time("every")),
                .boarding_after = seconds(boarding.time("after")),
                .boarding_duration = seconds(boarding.time("duration")),
                .boarding_heave = boarding.number("heave"),
                .boarding_roll = boarding.number("roll"),
                .boarding_pitch = boarding.number("pitch")};
  if (model.ride.boarding_every > 0 && model.ride.boarding_every < model.ride.boarding_duration)
    throw ComponentError("'every' is shorter than the 'duration' of a push", "/boarding/every");
  model.standing = read_shaking(shaking.object("standing"));
  model.driving = read_shaking(shaking.object("driving"));
  model.shaking_frequency = shaking.number("frequency");
  model.lever_arm = parameters.vector("lever_arm");
  const Eigen::Vector3d angles(mounting.number("roll"), mounting.number("pitch"), mounting.number("yaw"));
  if (!angles.isZero(0.0)) model.nominal = strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(angles));
  model.misalignment = mounting.vector("misalignment");
  model.misalignment_sigma = mounting.vector("misalignment_sigma");
  return model;
}

}  // namespace binnacle::vehicle_simulator
