// SPDX-License-Identifier: Apache-2.0
// Range rates: a row for each satellite of an epoch that has one.
#pragma once

#include "binnacle/spec.hpp"
#include "range_model.hpp"

namespace binnacle::gnss_range {

/// ρ̇ = (v_i − v_u)ᵀ u + d − c δṫ_i + v: paper 003 (7), u = −l. H: −uᵀ in the velocity's error (9), 1 for the clock's
/// drift, and the terms by position that (10) leaves out: the line of sight turns with it (1e-4 1/s), and so do the axes.
class RangeRateModel final : public RangeModel {
 public:
  static ComponentSpec spec();
  explicit RangeRateModel(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  AntennaVelocity velocity_;
};

}  // namespace binnacle::gnss_range
