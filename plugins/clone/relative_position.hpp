// SPDX-License-Identifier: Apache-2.0
// The displacement from an instant to now.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::clone {

/// z = A d + v, d the way from p(t₀), which a `clone` has kept, to p(t); A = C_bn(t₀) or I.
///
/// Of a geodetic position d [m; north, east, down at p(t₀)], with C = C_en and r the position in ECEF:
///     d = C(p₀)ᵀ (r(p) − r(p₀))     ∂d/∂δp = C(p₀)ᵀ C(p)     ∂d/∂δp₀ = −I + [d×] Θ
/// Θ δp₀ is the angle by which north, east and down turn as p₀ moves: (δE/(R_t+h), −δN/(R_m+h), −δE tan L/(R_t+h)).
/// Of a local vector d = p − p₀. With C_true = (I + [φ×]) Ĉ_nb, in body axes: ∂(C_bn d)/∂φ₀ = C_bn [d×].
class RelativePosition final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit RelativePosition(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  /// Of a local position with fewer components, what is left is zero.
  struct Way {
    Eigen::Vector3d d;  // m
    Eigen::Matrix3d by_position, by_copy;
  };
  struct Axis {
    Field z, reported;
    double sigma;  // where the channel reports none
  };

  Way way(const PortValues& x) const;

  Port position_, copy_, attitude_, age_;
  bool is_geodetic_, is_in_body_axes_;
  std::vector<Axis> axes_;
  double relative_;
  double tolerance_;  // s
};

}  // namespace binnacle::clone
