// SPDX-License-Identifier: Apache-2.0
// Zero-velocity update.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"
#include "spacing.hpp"

namespace binnacle::land {

/// r = 0 − v̂ [m/s, north east down], H = I: paper 001 (10), whose z is computed − true.
class Zupt final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Zupt(const Binding& binding);

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  void start(std::byte* memory) const override { spacing_.start(memory); }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const override;

 private:
  Spacing spacing_;
  MeasurementDeclaration declaration_;
  Eigen::Vector3d variance_;
};

}  // namespace binnacle::land
