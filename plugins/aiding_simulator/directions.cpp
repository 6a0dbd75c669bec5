// SPDX-License-Identifier: Apache-2.0
// Angles that other systems give: heading of a baseline, course over ground, attitude.
#include <cmath>
#include <numbers>

#include "binnacle/eigen.hpp"
#include "sensor.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::aiding_simulator {

namespace {

using Eigen::Vector3d;

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

/// z = heading of C_nb u + b + n; u from the rear to the front antenna.
class Heading final : public Sensor {
 public:
  explicit Heading(const Parameters& parameters)
      : noise_(parameters.number("noise")),
        baseline_(parameters.vector("baseline")),
        bias_(read_slow_error(parameters, "bias", "bias", "rad", "what the reading is too far to the right")) {}
  void declare(ChannelDeclaration& channel) override {
    heading_ = channel.carries(field::level("heading", "rad").about("of the baseline, clockwise from north"));
  }
  std::vector<SlowError> errors() const override { return {bias_}; }
  void measure(const Truth& truth, std::span<const double> e, Noise& noise, SampleWriter& out) const override {
    const Vector3d u = truth.C_nb * baseline_;
    out[heading_] = wrapped(std::atan2(u[1], u[0]) + e[0] + noise_ * noise.next());
  }

 private:
  double noise_;
  Vector3d baseline_;
  SlowError bias_;
  OutputField heading_;
};

/// z = atan2 of the horizontal velocity, each of its components with white noise.
class Course final : public Sensor {
 public:
  explicit Course(const Parameters& parameters) : velocity_noise_(parameters.number("velocity_noise")) {}
  void declare(ChannelDeclaration& channel) override {
    course_ = channel.carries(field::level("course", "rad").about("course over ground, clockwise from north"));
  }
  std::vector<SlowError> errors() const override { return {}; }
  void measure(const Truth& truth, std::span<const double>, Noise& noise, SampleWriter& out) const override {
    const double north = noise.next(), east = noise.next();
    out[course_] = std::atan2(truth.v_n[1] + velocity_noise_ * east, truth.v_n[0] + velocity_noise_ * north);
  }

 private:
  double velocity_noise_;
  OutputField course_;
};

/// C = exp([n×]) C_nb Mᵀ, n about north, east, down; M turns the body's axes into the other system's.
class Attitude final : public Sensor {
 public:
  explicit Attitude(const Parameters& parameters)
      : noise_(parameters.vector("noise")),
        M_(strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(parameters.vector("mounting")))) {}
  void declare(ChannelDeclaration& channel) override {
    angles_ = channel.carries(field::level("roll", "rad").about("roll, right side down positive"),
                              field::level("pitch", "rad").about("pitch, nose up positive"),
                              field::level("yaw", "rad").about("clockwise from true north"));
  }
  std::vector<SlowError> errors() const override { return {}; }
  void measure(const Truth& truth, std::span<const double>, Noise& noise, SampleWriter& out) const override {
    const Vector3d n = noise.next3();
    const Vector3d turn = noise_.cwiseProduct(n);
    const Eigen::Matrix3d C_ns = truth.C_nb * M_.transpose();
    out[angles_] =
        strapdown::euler_from_quaternion(strapdown::attitude_plus(strapdown::quaternion_from_dcm(C_ns), turn));
  }

 private:
  Vector3d noise_;
  Eigen::Matrix3d M_;
  OutputFields<3> angles_;
};

}  // namespace

SensorKind heading() {
  using namespace parameter;
  std::vector<ParameterSpec> own = {
      number("noise", "rad").at_least(0).defaults("0").about("1-sigma of the white noise"),
      vector("baseline", "1", 3)
          .defaults("[1, 0, 0]")
          .about("direction of the baseline in body axes, from the rear to the front antenna")};
  add_slow_error(own, "bias", "rad", "bias");
  return {"heading",
          sensor_object("heading", std::move(own), "two antennas or a compass, on the channel NAME.heading: heading"),
          [](const Parameters& parameters) { return std::make_unique<Heading>(parameters); }};
}

SensorKind course() {
  return {"course",
          sensor_object(
              "course",
              {parameter::number("velocity_noise", "m/s")
                   .at_least(0)
                   .defaults("0")
                   .about(
                       "1-sigma of the white noise of the velocity from which the course is computed, north and east")},
              "course over ground, on the channel NAME.course: course"),
          [](const Parameters& parameters) { return std::make_unique<Course>(parameters); }};
}

SensorKind attitude() {
  return {"attitude",
          sensor_object("attitude",
                        {parameter::vector("noise", "rad", 3)
                             .at_least(0)
                             .defaults("0")
                             .about("1-sigma of the white noise about north, east, down"),
                         parameter::vector("mounting", "rad", 3)
                             .defaults("[0, 0, 0]")
                             .about("roll, pitch, yaw of the rotation from the body's to the other system's axes: "
                                    "Rz(yaw) Ry(pitch) Rx(roll)")},
                        "attitude of another system, on the channel NAME.attitude: roll, pitch, yaw"),
          [](const Parameters& parameters) { return std::make_unique<Attitude>(parameters); }};
}

}  // namespace binnacle::aiding_simulator
