// SPDX-License-Identifier: Apache-2.0
// Position and velocity in earth-centred, earth-fixed axes.
#pragma once

#include "additive_block.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// WGS-84 ECEF position [m].
class EcefPosition final : public AdditiveBlock<3> {
 public:
  static ComponentSpec spec();
  explicit EcefPosition(const Binding& binding);
};

/// Velocity relative to the earth, in ECEF axes [m/s].
class EcefVelocity final : public AdditiveBlock<3> {
 public:
  static ComponentSpec spec();
  explicit EcefVelocity(const Binding& binding);
};

}  // namespace binnacle::gnss_range
