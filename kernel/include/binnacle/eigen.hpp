// SPDX-License-Identifier: Apache-2.0
// Eigen's side of view.hpp. Plugins have it from plugin.hpp; a program that reads views as Eigen maps includes it itself.
#pragma once

#include <Eigen/Core>

#include <type_traits>

#include "binnacle/view.hpp"

namespace binnacle {

static_assert(dynamic == Eigen::Dynamic);

/// Eigen's types of a Rows×Cols matrix, column-major; a Double that is const makes them const.
template <class Double, int Rows, int Cols>
struct EigenTypes {
  /// Owns its numbers.
  using Matrix = std::conditional_t<std::is_const_v<Double>, const Eigen::Matrix<double, Rows, Cols>,
                                    Eigen::Matrix<double, Rows, Cols>>;
  using Map = Eigen::Map<Matrix, Eigen::Unaligned>;                               ///< packed
  using StridedMap = Eigen::Map<Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;  ///< a block of a taller matrix
  using Stride = Eigen::OuterStride<>;                                            ///< of a StridedMap
};

}  // namespace binnacle
