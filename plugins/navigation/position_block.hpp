// SPDX-License-Identifier: Apache-2.0
// A geodetic position on the WGS-84 ellipsoid.
#pragma once

#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::navigation {

/// Stored: latitude [rad], longitude [rad], height [m]. Error: north, east, down [m], by the radii of curvature at the
/// estimate (strapdown::position_plus). Paper 003 (1) has δL, δl, δh and computed − true instead.
class PositionBlock final : public StateBlock {
 public:
  static ComponentSpec spec();
  explicit PositionBlock(const Binding& binding);

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override;
  void read(ConstVectorView x, VectorView outputs) const override;
  Result write(ConstVectorView outputs, VectorView x) const override;
  /// Of strapdown::position_plus(): exact.
  bool output_jacobian(ConstVectorView x, MatrixView J) const override;

 private:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::navigation
