// SPDX-License-Identifier: Apache-2.0
// A fixed rotation between two sets of axes on one body, as a config gives it.
#pragma once

#include <Eigen/Core>

#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// A rotation R by roll, pitch, yaw, by "euler", "quaternion" or "matrix" (one of them); "flip", "inverse".
std::vector<ParameterSpec> mounting_parameters();

/// C = D R takes components in the first axes to components in the second; R = Rz(yaw) Ry(pitch) Rx(roll) where it is given so;
/// D = diag(1, −1, −1) when flip is flu_to_frd (R then leads to forward-left-up axes), else I. With "inverse" Cᵀ. Throws
/// ComponentError where a matrix or quaternion is no rotation, or R is given twice.
Eigen::Matrix3d mounting_rotation(const Parameters& parameters);

}  // namespace binnacle::frames
