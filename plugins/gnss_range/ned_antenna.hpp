// SPDX-License-Identifier: Apache-2.0
// An ECEF position and velocity as blocks of the geodetic kinds.
#pragma once

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// Latitude, longitude, height of an ECEF position; its error north, east, down. J = C_enᵀ.
class GeodeticPosition final : public legacy::DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit GeodeticPosition(const Binding& binding);

  const DerivedDeclaration& declaration() const noexcept override { return declaration_; }
  Result evaluate(const double* const* x, const legacy::Context& context, double* value,
                  const MatrixView* J) const override;

 private:
  DerivedDeclaration declaration_;
};

/// v_n = C_enᵀ v_e. J: C_enᵀ for the velocity, and how the axes turn with the position.
class NedVelocity final : public legacy::DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit NedVelocity(const Binding& binding);

  const DerivedDeclaration& declaration() const noexcept override { return declaration_; }
  Result evaluate(const double* const* x, const legacy::Context& context, double* value,
                  const MatrixView* J) const override;

 private:
  DerivedDeclaration declaration_;
};

}  // namespace binnacle::gnss_range
