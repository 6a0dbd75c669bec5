// SPDX-License-Identifier: Apache-2.0
// A receiver that moves with nearly constant velocity: the GPS-only filter.
#pragma once

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// ṙ = v, v̇ = w, the same density S_a [m²/s³] in each direction: six of the eight states of paper 003, section 4.2.
class EcefPv final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit EcefPv(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const legacy::ProcessOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  double S_a_;
  double S_v_;
};

}  // namespace binnacle::gnss_range
