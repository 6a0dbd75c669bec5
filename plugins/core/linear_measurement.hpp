// SPDX-License-Identifier: Apache-2.0
// A vector, or a linear combination of its components, measured directly.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// z = H x + b + v, E[v vᵀ] = diag(σ²); r = z − H x̂ − b̂.
class LinearMeasurement final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit LinearMeasurement(const Binding& binding);

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const override;

 private:
  MeasurementDeclaration declaration_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd variance_;  // unit²
  bool has_bias_;
};

}  // namespace binnacle::core
