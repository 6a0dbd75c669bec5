// SPDX-License-Identifier: Apache-2.0
// A velocity in the axes of the vehicle or of a sensor on it, with what it depends on.
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/view.hpp"

namespace binnacle::vehicle {

/// v_v = exp([ζ×]) C_bn v_n [m/s; forward, right, down]: paper 001 (2), (5), (6), (5) being C_v^b = I − [ζ×].
/// With δ = truth − estimate throughout (attitude: C_true = (I + [φ×]) Ĉ), E = exp([ζ×]):
///   ∂v_v/∂v_n = E C_bn     ∂v_v/∂φ = E C_bn [v_n×]     ∂v_v/∂ζ = −[v_v×] J_l(ζ)
class VehicleVelocity {
 public:
  /// velocity, attitude, misalignment; the texts say of what point and of what axes.
  static std::vector<PortSpec> ports(std::string of_point, std::string of_axes);

  /// Declares its ports as read; refuses a misalignment that has neither two (y, z) nor three components.
  VehicleVelocity(const Binding& binding, MeasurementDeclaration& declaration);

  struct Value {
    Eigen::Vector3d v_v;
    Eigen::Matrix3d by_velocity, by_attitude, by_misalignment;
  };
  Value at(const PortValues& x) const;

  /// H = direction · ∂v_v/∂(port) for each of its ports; direction: rows × 3, at most 3 rows.
  template <class Direction>
  void write_jacobians(const Value& value, const Eigen::MatrixBase<Direction>& direction,
                       const PortJacobians& H) const {
    if (!H) return;
    H[velocity_].as() = direction * value.by_velocity;
    H[attitude_].as() = direction * value.by_attitude;
    if (misalignment_.dof() == 3) H[misalignment_].as() = direction * value.by_misalignment;
    if (misalignment_.dof() == 2) H[misalignment_].as() = direction * value.by_misalignment.rightCols<2>();
  }

 private:
  Port velocity_, attitude_, misalignment_;
};

}  // namespace binnacle::vehicle
