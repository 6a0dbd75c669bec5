// SPDX-License-Identifier: Apache-2.0
// What a simulated sensor is: its parameters, its channel, its slow errors, its reading.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/parameters.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"
#include "random/normal.hpp"

namespace binnacle::aiding_simulator {

/// Where the body is at a sample of the input.
struct Truth {
  Eigen::Vector3d lla;         // rad, rad, m
  Eigen::Vector3d v_n;         // m/s
  Eigen::Matrix3d C_nb;        // body to north, east, down
  Eigen::Vector3d omega_ib_b;  // rad/s; NaN where the input has none
};

/// An error that stays, or wanders slowly: N(0, constant²), drawn once a run, + a stationary Gauss–Markov process of standard
/// deviation `wandering` and correlation time `tau`. A number of the channel `truth`, SENSOR_NAME.
struct SlowError {
  std::string name, unit, text;
  double constant = 0, wandering = 0, tau = 1;
};

/// White noise: deviates of N(0, 1), or zeros where everything is perfect. Streams are used alike in both.
class Noise {
 public:
  Noise(random::Philox& stream, bool is_perfect) : stream_(stream), size_(is_perfect ? 0 : 1) {}
  double next() { return size_ * random::normal(stream_); }
  Eigen::Vector3d next3() {
    const double x = next(), y = next(), z = next();
    return {x, y, z};
  }
  /// An exponential deviate of this mean with the probability `share`, else 0. Two draws.
  double exponential(double mean, double share) {
    const double chance = random::uniform(stream_), deviate = -mean * std::log(1 - random::uniform(stream_));
    return chance < share ? size_ * deviate : 0.0;
  }

 private:
  random::Philox& stream_;
  double size_;
};

/// Immutable once it is declared. All that changes is handed in.
class Sensor {
 public:
  virtual ~Sensor() = default;
  /// The fields of its channel. It keeps the handles.
  virtual void declare(ChannelDeclaration& channel) = 0;
  virtual std::vector<SlowError> errors() const = 0;
  /// Without it `Truth::omega_ib_b` may be NaN.
  virtual bool needs_rates() const { return false; }
  /// A reading. `errors`: as errors() lists them, at this instant. As many deviates are drawn whatever their sizes.
  virtual void measure(const Truth& truth, std::span<const double> errors, Noise& noise, SampleWriter& out) const = 0;
};

/// A kind of sensor that the simulator may have.
struct SensorKind {
  const char* name;    // of the parameter and of the channel
  ParameterSpec spec;  // an object
  std::function<std::unique_ptr<Sensor>(const Parameters&)> make;
};
/// All there are, in the order of the channels.
std::vector<SensorKind> sensor_kinds();

SensorKind magnetometer();
SensorKind height();
SensorKind body_velocity();
SensorKind heading();
SensorKind course();
SensorKind attitude();
SensorKind range();
SensorKind range_difference();

// ---- for those who write one

/// `every`, then the sensor's own; an object that may be left out.
ParameterSpec sensor_object(const char* name, std::vector<ParameterSpec> own, const char* text);
ParameterSpec lever_arm_parameter();
/// NAME, NAME_wandering and NAME_tau: the standard deviations of a slow error.
void add_slow_error(std::vector<ParameterSpec>& to, const std::string& name, const std::string& unit,
                    const std::string& text);
/// What add_slow_error() added, for an error called `error`.
SlowError read_slow_error(const Parameters& parameters, const std::string& name, std::string error, std::string unit,
                          std::string text);
/// Position and velocity of a point of the body that is `lever_arm` [m, body axes] from where the truth is. Without
/// lever arm the truth's, to the bit.
Eigen::Vector3d position_at(const Truth& truth, const Eigen::Vector3d& lever_arm);
Eigen::Vector3d velocity_at(const Truth& truth, const Eigen::Vector3d& lever_arm);

}  // namespace binnacle::aiding_simulator
