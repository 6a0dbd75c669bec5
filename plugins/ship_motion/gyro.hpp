// SPDX-License-Identifier: Apache-2.0
// Gyros that read angles or rates of the ship, with noise and drift.
#pragma once

#include <vector>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_motion {

/// z = x + e + v per axis; e is the block on the axis' error port: an accumulated drift, shared with another gyro or not.
class Gyro : public MeasurementModel {
 public:
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const final;

 protected:
  explicit Gyro(const Binding& binding);

 private:
  struct Axis {
    Field z;
    Port x, error;
  };
  std::vector<Axis> axes_;
  double variance_;
};

class VerticalGyro final : public Gyro {
 public:
  static ComponentSpec spec();
  explicit VerticalGyro(const Binding& binding) : Gyro(binding) {}
};

class DirectionalGyro final : public Gyro {
 public:
  static ComponentSpec spec();
  explicit DirectionalGyro(const Binding& binding) : Gyro(binding) {}
};

class RateGyro final : public Gyro {
 public:
  static ComponentSpec spec();
  explicit RateGyro(const Binding& binding) : Gyro(binding) {}
};

}  // namespace binnacle::ship_motion
