// SPDX-License-Identifier: Apache-2.0
// ECEF positions of a channel in geodetic terms.
#pragma once

#include "binnacle/source.hpp"
#include "solution_fields.hpp"

namespace binnacle::gnss_range {

/// x, y, z as latitude, longitude and height, vx, vy, vz as velocity north, east, down; NaN stays NaN.
class GeodeticTrack final : public Transform {
 public:
  static ComponentSpec spec();
  explicit GeodeticTrack(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  Fields<3> position_, velocity_;
  OutputChannel channel_;
  PlaceFields fields_;
};

}  // namespace binnacle::gnss_range
