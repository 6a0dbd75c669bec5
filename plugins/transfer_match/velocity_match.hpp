// SPDX-License-Identifier: Apache-2.0
// A slave's velocity held against its master's.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::transfer_match {

/// Paper 000 (2) is z_v = v_SINS − v_MINS = δv + v with δ = computed − true. Here r = z ⊟ h(x̂) = v_MINS + u − v̂_SINS and
/// H_v = +I, with u the velocity of the slave's place against the master's (the paper has none):
///   u = ω_eb × (C_M l),  ω_eb = C_S (ω − b_g) − ω_ie, l on port `lever_arm`, C_M from the sample, ω the drive's mean rate
///   H_attitude = −[(C_M l)×][C_S(ω − b_g) ×]    H_gyro_bias = −[(C_M l)×] C_S    H_arm = −[ω_eb×] C_M
class VelocityMatch final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit VelocityMatch(const Binding& binding);

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const override;

 private:
  Eigen::Vector3d earth_rate(const SampleView& sample) const;

  MeasurementDeclaration declaration_;
  Eigen::Vector3d variance_;  // (m/s)²
  int rows_;
  bool has_lever_arm_;
  bool has_latitude_;
};

}  // namespace binnacle::transfer_match
