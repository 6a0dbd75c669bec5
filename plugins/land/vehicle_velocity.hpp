// SPDX-License-Identifier: Apache-2.0
// A velocity in the axes of the vehicle, with what it depends on.
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/view.hpp"

namespace binnacle::land {

/// v_v = exp([ζ×]) C_bn v_n [m/s; forward, right, down]: paper 001 (2), (5), (6), (5) being C_v^b = I − [ζ×].
/// With δ = truth − estimate throughout (attitude: C_true = (I + [φ×]) Ĉ), E = exp([ζ×]):
///   ∂v_v/∂v_n = E C_bn     ∂v_v/∂φ = E C_bn [v_n×]     ∂v_v/∂ζ = −[v_v×] J_l(ζ)
/// The first three ports of every model that uses it are velocity, attitude, misalignment.
class VehicleVelocity {
 public:
  static std::vector<PortSpec> ports();

  /// Refuses a misalignment that has neither two (y, z) nor three components.
  explicit VehicleVelocity(const Binding& binding);

  /// Ports with a Jacobian, in the order in which write_jacobians() takes them.
  std::vector<int> read_ports() const;

  struct Value {
    Eigen::Vector3d v_v;
    Eigen::Matrix3d by_velocity, by_attitude, by_misalignment;
  };
  Value at(const double* const* x) const;

  /// H[k] = direction · ∂v_v/∂(k-th of read_ports()); direction: rows × 3.
  template <int Rows>
  void write_jacobians(const Value& value, const Eigen::Matrix<double, Rows, 3>& direction, const MatrixView* H) const {
    H[0].as() = direction * value.by_velocity;
    H[1].as() = direction * value.by_attitude;
    if (angles_ == 3) H[2].as() = direction * value.by_misalignment;
    if (angles_ == 2) H[2].as() = direction * value.by_misalignment.rightCols<2>();
  }

 private:
  int angles_;  // components of the misalignment; 0: the port is open
};

}  // namespace binnacle::land
