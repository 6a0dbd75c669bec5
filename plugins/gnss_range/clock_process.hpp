// SPDX-License-Identifier: Apache-2.0
// How a receiver's clock wanders: two states.
#pragma once

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// ḃ = d + w_f, ḋ = w_g, with densities S_f [m²/s] and S_g [m²/s³] (paper 003 (4); Brown and Hwang, Introduction to
/// Random Signals and Applied Kalman Filtering, 3rd ed., section 11.2).
class ClockProcess final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit ClockProcess(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const legacy::ProcessOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  double S_f_, S_g_;
};

}  // namespace binnacle::gnss_range
