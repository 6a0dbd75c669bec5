// SPDX-License-Identifier: Apache-2.0
// Zero angular rate: what the gyroscopes tell of a body at rest is the earth's rate and their bias.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"
#include "spacing.hpp"

namespace binnacle::land {

/// h = b_g + C_bn ω_ie_n [rad/s, body axes], r = ω_measured − h. Without position and attitude the earth's rate is left
/// out. H = +∂h/∂δ: I for b_g, C_bn [ω_ie×] for φ, C_bn ∂ω_ie/∂N for the position's first component.
class ZeroRate final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit ZeroRate(const Binding& binding);

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  void start(std::byte* memory) const override { spacing_.start(memory); }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const override;

 private:
  Spacing spacing_;
  MeasurementDeclaration declaration_;
  Eigen::Vector3d variance_;
  bool has_earth_;
};

}  // namespace binnacle::land
