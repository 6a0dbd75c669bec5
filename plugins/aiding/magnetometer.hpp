// SPDX-License-Identifier: Apache-2.0
// The earth's magnetic field in body axes.
#pragma once

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "deviations.hpp"

namespace binnacle::aiding {

/// z = S m_b + h + v, m_b = C_bn m_n [T]. S = S₀ + ΔS, h = h₀ + Δh; ΔS and Δh on optional ports. With C_true = (I + [φ×]) Ĉ:
///     ∂/∂φ = S C_bn [m_n×]     ∂/∂Δh = I     ∂/∂ΔS: element ij of row i by m_b,j
/// ΔS has 3 components (xx yy zz), 6 (xx yy zz xy xz yz, symmetric) or 9 (row by row).
class Magnetometer final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Magnetometer(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Eigen::Matrix3d soft_iron(const PortValues& x) const;
  void write_soft_iron(const Eigen::Vector3d& m_b, const MatrixView& H) const;

  Port attitude_, hard_iron_, soft_iron_;
  Fields<3> z_, given_field_;
  Input input_;
  Deviations sigma_;
  Eigen::Vector3d field_n_;  // T, where no channel gives it
  Eigen::Vector3d fixed_hard_iron_;
  Eigen::Matrix3d fixed_soft_iron_;
};

}  // namespace binnacle::aiding
