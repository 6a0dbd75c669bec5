// SPDX-License-Identifier: Apache-2.0
// Gyros that read angles or rates of the ship, with noise and drift.
#pragma once

#include <vector>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_motion {

/// z = x + e + v per axis; e is the block on the axis' error port: an accumulated drift, shared with another gyro or not.
class Gyro : public legacy::MeasurementModel {
 public:
  const MeasurementDeclaration& declaration() const noexcept final { return declaration_; }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const final;

 protected:
  explicit Gyro(const Binding& binding);

 private:
  struct Axis {
    int field = 0;
    int port = 0, error_port = -1;          // −1: none
    int jacobian = 0, error_jacobian = -1;  // index in MeasurementDeclaration::reads
  };
  MeasurementDeclaration declaration_;
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
