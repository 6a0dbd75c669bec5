// SPDX-License-Identifier: Apache-2.0
// A fixed rotation between two sets of axes on one body, as a config gives it.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// roll, pitch, yaw [rad] and flip, each zero or none unless given.
std::vector<ParameterSpec> mounting_parameters();

/// C = D Rz(yaw) Ry(pitch) Rx(roll) takes components in the first axes to components in the second; D = diag(1, −1, −1)
/// when flip is flu_to_frd (the angles then lead to forward-left-up axes), else I.
Eigen::Matrix3d mounting_rotation(const Parameters& parameters);

}  // namespace binnacle::frames
