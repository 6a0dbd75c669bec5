// SPDX-License-Identifier: Apache-2.0
// How a receiver's clock wanders: two states.
#pragma once

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// ḃ = d + w_f, ḋ = w_g, with densities S_f [m²/s] and S_g [m²/s³] (paper 003 (4); Brown and Hwang, Introduction to
/// Random Signals and Applied Kalman Filtering, 3rd ed., section 11.2).
class ClockProcess final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit ClockProcess(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  Port clock_;
  PhiBlock phi_;
  QBlock q_;
  double S_f_, S_g_;
};

}  // namespace binnacle::gnss_range
