// SPDX-License-Identifier: Apache-2.0
// Position and velocity in earth-centred, earth-fixed axes.
#pragma once

#include "binnacle/spec.hpp"
#include "blocks/additive_block.hpp"

namespace binnacle::gnss_range {

/// WGS-84 ECEF position [m].
class EcefPosition final : public blocks::AdditiveBlock {
 public:
  static ComponentSpec spec();
  explicit EcefPosition(const Binding& binding);
};

/// Velocity relative to the earth, in ECEF axes [m/s].
class EcefVelocity final : public blocks::AdditiveBlock {
 public:
  static ComponentSpec spec();
  explicit EcefVelocity(const Binding& binding);
};

}  // namespace binnacle::gnss_range
