// SPDX-License-Identifier: Apache-2.0
// The fields that simulators declare.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "binnacle/eigen.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::simulation {

/// Three fields that are written as one vector.
using Triad = std::array<FieldSpec, 3>;

FieldSpec level(std::string name, std::string unit, std::string text);
/// PREFIXx, PREFIXy, PREFIXz in body axes.
Triad triad(const std::string& prefix, const std::string& unit, const std::string& text);
Triad position_fields();  // lat lon height
Triad velocity_fields();  // vn ve vd
Triad attitude_fields();  // roll pitch yaw

/// Three standard deviations, none below zero.
ParameterSpec sigmas(std::string name, const std::string& unit, const std::string& defaults, const std::string& text);

/// wx wy wz fx fy fz, as rates or as increments.
struct ImuFields {
  OutputFields<3> w, f;
};
ImuFields carry_imu(ChannelDeclaration& channel, bool emits_rates);

/// position.*, velocity.*, attitude.*, each north, east, down.
std::vector<NamedUnit> navigation_covariance();

}  // namespace binnacle::simulation
