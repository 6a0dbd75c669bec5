// SPDX-License-Identifier: Apache-2.0
// Eigen's side of view.hpp. Plugins have it from plugin.hpp; a program that reads views as Eigen maps includes it itself.
#pragma once

#include <Eigen/Core>

#include <type_traits>

#include "binnacle/view.hpp"

namespace binnacle {

static_assert(dynamic == Eigen::Dynamic);

template <class Double, int Rows, int Cols>
struct EigenTypes {
  using Matrix = std::conditional_t<std::is_const_v<Double>, const Eigen::Matrix<double, Rows, Cols>,
                                    Eigen::Matrix<double, Rows, Cols>>;
  using Map = Eigen::Map<Matrix, Eigen::Unaligned>;
  using StridedMap = Eigen::Map<Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;
  using Stride = Eigen::OuterStride<>;
};

}  // namespace binnacle
