// SPDX-License-Identifier: Apache-2.0
// A receiver that moves with nearly constant velocity, in north, east, down.
#pragma once

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// ṗ = v, v̇ = w in north, east, down, with a density of w [m²/s³] along the horizontal and one along the vertical: ecef_pv for
/// the geodetic kinds. That the axes turn as the vehicle moves is left out of v: at 30 m/s it is 1e-4 m/s².
class NedPv final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit NedPv(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  Port position_, velocity_;
  PhiBlock phi_pp_, phi_pv_;
  QBlock q_pp_, q_pv_, q_vv_;
  double S_horizontal_, S_vertical_, S_v_;
};

}  // namespace binnacle::gnss_range
