// SPDX-License-Identifier: Apache-2.0
// A vector, or a linear combination of its components, measured directly.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// z = H x + b + v, E[v vᵀ] = diag(σ²); r = z − H x̂ − b̂.
class LinearMeasurement final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit LinearMeasurement(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port x_;
  Port bias_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd variance_;  // unit²
  std::vector<Field> z_;
};

}  // namespace binnacle::core
