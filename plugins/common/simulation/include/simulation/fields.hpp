// SPDX-License-Identifier: Apache-2.0
// The fields that simulators declare, and how they are filled.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::simulation {

using FieldList = std::vector<FieldSpec>;

FieldSpec level(std::string name, std::string unit, std::string text);
FieldList joined(std::initializer_list<FieldList> parts);
/// PREFIXx, PREFIXy, PREFIXz in body axes.
FieldList triad(const std::string& prefix, const std::string& unit, const std::string& text);
FieldList position_fields();  // lat lon height
FieldList velocity_fields();  // vn ve vd
FieldList attitude_fields();  // roll pitch yaw
/// wx wy wz fx fy fz, as rates or as increments.
FieldList imu_fields(bool emits_rates);
/// position.*, velocity.*, attitude.*, each north, east, down.
std::vector<NamedUnit> navigation_covariance();

/// Writes numbers one after another into a slot's fields.
class FieldWriter {
 public:
  explicit FieldWriter(SampleSlot& slot) : next_(slot.fields) {}
  FieldWriter& operator<<(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) *next_++ = v[i];
    return *this;
  }
  FieldWriter& operator<<(double value) {
    *next_++ = value;
    return *this;
  }

 private:
  double* next_;
};

}  // namespace binnacle::simulation
