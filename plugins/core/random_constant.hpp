// SPDX-License-Identifier: Apache-2.0
// A block that does not move.
#pragma once

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = 0 without noise, for a block of any kind. Φ = I and Qd = 0 are not even listed, so the kernel skips them.
class RandomConstant final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit RandomConstant(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const legacy::ProcessOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  int stored_size_;
};

}  // namespace binnacle::core
