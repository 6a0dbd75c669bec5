// SPDX-License-Identifier: Apache-2.0
// One degree of freedom of a ship in waves: white noise through a shaping filter of order 2 or 4.
#pragma once

#include <vector>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_motion {

/// θ̈ + 2ζωθ̇ + ω²θ = s, where s is white or itself such a motion; discretized by the kernel (Van Loan).
class Motion final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit Motion(const Binding& binding);

  void linearized(const ContinuousInput& in, ContinuousOutput& out) const override;

 private:
  struct Element {
    PhiBlock place;
    double value;  // of F: of angle, rate and, of order 4, s, ṡ
  };
  std::vector<Element> F_;
  QBlock q_;
  double density_ = 0;  // of the white noise on the last state [unit²/s]
};

}  // namespace binnacle::ship_motion
