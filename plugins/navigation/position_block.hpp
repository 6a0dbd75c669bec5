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
  void plus(const double* x, const double* delta, double* result) const override;
  void minus(const double* y, const double* x, double* delta) const override;
  void read(const double* x, double* outputs) const override;
  Result write(const double* outputs, double* x) const override;

 private:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::navigation
