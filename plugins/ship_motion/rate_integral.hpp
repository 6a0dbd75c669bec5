// SPDX-License-Identifier: Apache-2.0
// An angle driven by a rate gyro: filter C.
#pragma once

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_motion {

/// θ̇ = u − b − n: the gyro's reading u, its drift b, its white noise n.
class RateIntegral final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit RateIntegral(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  Port angle_, drift_;
  Field rate_;
  PhiBlock phi_;
  QBlock q_;
  double density_;  // of n [unit²/s]
};

}  // namespace binnacle::ship_motion
