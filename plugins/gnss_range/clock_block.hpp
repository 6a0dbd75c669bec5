// SPDX-License-Identifier: Apache-2.0
// The receiver's clock.
#pragma once

#include "binnacle/spec.hpp"
#include "blocks/additive_block.hpp"

namespace binnacle::gnss_range {

/// Bias [m] and drift [m/s] of the receiver's clock, c times its seconds: paper 003 (4), c_bias and c_drift. Positive
/// when the clock is ahead, so that it adds to a pseudorange.
class ClockBlock final : public blocks::AdditiveBlock {
 public:
  static ComponentSpec spec();
  explicit ClockBlock(const Binding& binding);
};

}  // namespace binnacle::gnss_range
