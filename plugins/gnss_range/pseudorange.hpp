// SPDX-License-Identifier: Apache-2.0
// Pseudoranges: a row for each satellite of an epoch.
#pragma once

#include "binnacle/spec.hpp"
#include "range_model.hpp"

namespace binnacle::gnss_range {

/// ρ = |R(ωτ) r_i − r_u| + b + o_s − c (δt_i − T_GD) + I + T + v: paper 003 (5), with what it leaves to the receiver.
/// H: −uᵀ scale in the position's error (6), 1 for the clock's bias and
/// for the offset o_s of the satellite's system; u points from the antenna to the satellite, so
/// paper 003's l = −u.
class Pseudorange final : public RangeModel {
 public:
  static ComponentSpec spec();
  explicit Pseudorange(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port system_offset_;
};

}  // namespace binnacle::gnss_range
