// SPDX-License-Identifier: Apache-2.0
// A velocity as a receiver computes it.
#pragma once

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"
#include "reported_sigma.hpp"

namespace binnacle::gnss_fix {

/// r = z − v̂ [m/s, north east down], H = I (paper 003 (11), whose I₆ is PositionFix and this).
class VelocityFix final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit VelocityFix(const Binding& binding);

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const override;

 private:
  MeasurementDeclaration declaration_;
  ReportedSigma sigma_;
};

}  // namespace binnacle::gnss_fix
