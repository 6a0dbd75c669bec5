// SPDX-License-Identifier: Apache-2.0
// Whether what a plugin gives as a noise covariance can be one.
#pragma once

#include <string>

#include "binnacle/view.hpp"

namespace binnacle::filter {

/// True if no element is infinite or not a number, no variance is negative, and R is symmetric but for rounding.
bool is_noise(MatrixView R);
/// "R(1, 1) = -4, which is no variance", of what is_noise() refuses.
std::string flaw_of_noise(MatrixView R);

}  // namespace binnacle::filter
