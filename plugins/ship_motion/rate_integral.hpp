// SPDX-License-Identifier: Apache-2.0
// An angle driven by a rate gyro: filter C.
#pragma once

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_motion {

/// θ̇ = u − b − n: the gyro's reading u, its drift b, its white noise n.
class RateIntegral final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit RateIntegral(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const legacy::ProcessOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  double density_;  // of n [unit²/s]
  bool has_drift_;
};

}  // namespace binnacle::ship_motion
