// SPDX-License-Identifier: Apache-2.0
// A velocity over ground in north-east-down axes.
#pragma once

#include "binnacle/spec.hpp"
#include "blocks/additive_block.hpp"

namespace binnacle::navigation {

/// Stored, error and outputs: north, east, down [m/s]; ⊞ and ⊟ are + and −.
class VelocityBlock final : public blocks::AdditiveBlock {
 public:
  static ComponentSpec spec();
  explicit VelocityBlock(const Binding& binding);
};

}  // namespace binnacle::navigation
