// SPDX-License-Identifier: Apache-2.0
// The displacement from an instant to now.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "strapdown/place.hpp"

namespace binnacle::clone {

/// z = A d + v, d the way from p(t₀), which a `clone` has kept, to p(t); A = C_bn(t₀) or I.
///
/// Of a place on the earth d is in north, east, down at p(t₀), strapdown::navigation_way(), or in ECEF axes; of a geodetic one,
/// with C = C_en and r the position in ECEF:
///     d = C(p₀)ᵀ (r(p) − r(p₀))     ∂d/∂δp = C(p₀)ᵀ C(p)     ∂d/∂δp₀ = −I + [d×] Θ
///     d_e = r(p) − r(p₀)            ∂d_e/∂δp = C(p)          ∂d_e/∂δp₀ = −C(p₀)
/// Θ δp₀ is the angle by which north, east and down turn as p₀ moves: (δE/(R_t+h), −δN/(R_m+h), −δE tan L/(R_t+h)).
/// Of a local vector d = p − p₀. With C_true = (I + [φ×]) Ĉ_nb, in body axes: ∂(C_bn d)/∂φ₀ = C_bn [d×].
class RelativePosition final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit RelativePosition(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  struct Axis {
    Field z, reported;
    double sigma;  // where the channel reports none
  };

  strapdown::Way way(const PortValues& x) const;

  Port position_, copy_, attitude_, age_;
  strapdown::PlaceKind kind_ = strapdown::PlaceKind::local;
  bool is_in_body_axes_, is_in_ecef_;
  std::vector<Axis> axes_;
  double relative_;
  double tolerance_;  // s
};

}  // namespace binnacle::clone
