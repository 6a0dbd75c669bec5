// SPDX-License-Identifier: Apache-2.0
// One degree of freedom of a ship in waves: white noise through a shaping filter of order 2 or 4.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_motion {

/// θ̈ + 2ζωθ̇ + ω²θ = s, where s is white or itself such a motion; discretized by the kernel (Van Loan).
class Motion final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit Motion(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  void linearized(const double* const* x, const legacy::ContinuousOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  Eigen::MatrixXd F_;   // angle, rate and, of order 4, s, ṡ
  double density_ = 0;  // of the white noise on the last state [unit²/s]
};

}  // namespace binnacle::ship_motion
