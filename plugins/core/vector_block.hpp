// SPDX-License-Identifier: Apache-2.0
// A vector of like quantities as a state block: biases, scale factors, lever arms, misalignments.
#pragma once

#include "binnacle/spec.hpp"
#include "blocks/additive_block.hpp"

namespace binnacle::core {

/// Kind "vector:N:UNIT". Stored value, error and outputs are the same N numbers [UNIT, SI]; ⊞ and ⊟ are + and −.
class VectorBlock final : public blocks::AdditiveBlock {
 public:
  static ComponentSpec spec();
  explicit VectorBlock(const Binding& binding);
};

}  // namespace binnacle::core
