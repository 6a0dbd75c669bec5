// SPDX-License-Identifier: Apache-2.0
// Whether what a plugin gives can be numbers at all, or a noise covariance.
#pragma once

#include <string>

#include "binnacle/view.hpp"

namespace binnacle::filter {

inline bool is_finite(ConstVectorView x) { return (x.as().array() * 0.0).sum() == 0.0; }
inline bool is_finite(ConstMatrixView A) { return (A.as().array() * 0.0).sum() == 0.0; }

/// True if no element is infinite or not a number, no variance is negative, and R is symmetric but for rounding.
bool is_noise(ConstMatrixView R);
/// "R(1, 1) = -4, which is no variance", of what is_noise() refuses.
std::string flaw_of_noise(ConstMatrixView R);

}  // namespace binnacle::filter
