// SPDX-License-Identifier: Apache-2.0
// A velocity in body axes: a Doppler log, a wheel.
#include <cmath>

#include "binnacle/eigen.hpp"
#include "sensor.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::aiding_simulator {

namespace {

using Eigen::Vector3d;

/// z = (1 + s) exp([ζ×]) C_bn v_n + n, v_n of the sensor's place; n: noise² + (relative v)² by axis.
class BodyVelocity final : public Sensor {
 public:
  explicit BodyVelocity(const Parameters& parameters)
      : noise_(parameters.vector("noise")),
        relative_(parameters.number("relative")),
        scale_(parameters.number("scale")),
        misalignment_(parameters.vector("misalignment")),
        lever_arm_(parameters.vector("lever_arm")) {}
  void declare(ChannelDeclaration& channel) override {
    v_ = channel.carries(field::level("vx", "m/s").about("velocity over ground along the sensor's x, forward"),
                         field::level("vy", "m/s").about("velocity over ground along y, right"),
                         field::level("vz", "m/s").about("velocity over ground along z, down"));
  }
  std::vector<SlowError> errors() const override {
    return {{"scale", "1", "scale factor error", scale_},
            {"mount_x", "rad", "misalignment about x", misalignment_[0]},
            {"mount_y", "rad", "about y", misalignment_[1]},
            {"mount_z", "rad", "about z", misalignment_[2]}};
  }
  bool needs_rates() const override { return !lever_arm_.isZero(0.0); }
  void measure(const Truth& truth, std::span<const double> e, Noise& noise, SampleWriter& out) const override {
    const Vector3d v_b = truth.C_nb.transpose() * velocity_at(truth, lever_arm_);
    const Vector3d zeta(e[1], e[2], e[3]);
    const Vector3d v = (1 + e[0]) * strapdown::dcm_from_quaternion(strapdown::quaternion_exp(zeta)) * v_b;
    const Vector3d n = noise.next3();
    Vector3d reading = v;
    const double by_speed = relative_ * v.norm();
    for (int i = 0; i < 3; ++i) reading[i] += std::hypot(noise_[i], by_speed) * n[i];
    out[v_] = reading;
  }

 private:
  Vector3d noise_;
  double relative_, scale_;
  Vector3d misalignment_, lever_arm_;
  OutputFields<3> v_;
};

}  // namespace

SensorKind body_velocity() {
  using namespace parameter;
  return {
      "body_velocity",
      sensor_object("body_velocity",
                    {vector("noise", "m/s", 3).at_least(0).defaults("0").about("1-sigma of the white noise, by axis"),
                     number("relative", "1")
                         .at_least(0)
                         .defaults("0")
                         .about("1-sigma of additional white noise, relative to the speed, by axis"),
                     number("scale", "1")
                         .at_least(0)
                         .defaults("0")
                         .about("1-sigma of the scale factor error, drawn once per run"),
                     vector("misalignment", "rad", 3)
                         .at_least(0)
                         .defaults("0")
                         .about("1-sigma of the misalignment about x, y, z, drawn once per run"),
                     lever_arm_parameter()},
                    "Doppler log or wheel sensors, on the channel NAME.body_velocity: vx, vy, vz"),
      [](const Parameters& parameters) { return std::make_unique<BodyVelocity>(parameters); }};
}

}  // namespace binnacle::aiding_simulator
