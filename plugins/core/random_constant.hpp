// SPDX-License-Identifier: Apache-2.0
// A block that does not move.
#pragma once

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = 0 without noise, for a block of any kind. Φ = I and Qd = 0 are not even listed, so the kernel skips them.
class RandomConstant final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit RandomConstant(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  Port x_;
};

}  // namespace binnacle::core
