// SPDX-License-Identifier: Apache-2.0
// An ECEF position and velocity as blocks of the geodetic kinds.
#pragma once

#include "binnacle/derived_block.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// Latitude, longitude, height of an ECEF position; its error north, east, down. J = C_enᵀ.
class GeodeticPosition final : public DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit GeodeticPosition(const Binding& binding);

  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override;

 private:
  Port ecef_position_;
};

/// v_n = C_enᵀ v_e. J: C_enᵀ for the velocity, and how the axes turn with the position.
class NedVelocity final : public DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit NedVelocity(const Binding& binding);

  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override;

 private:
  Port ecef_position_, ecef_velocity_;
};

}  // namespace binnacle::gnss_range
