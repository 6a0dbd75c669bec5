// SPDX-License-Identifier: Apache-2.0
// Positions of a channel from geodetic to local coordinates, and back.
#pragma once

#include "binnacle/local_axes.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// lat, lon, height become north, east, down and up of an origin [m]; vn, ve, vd the velocity along its axes [m/s].
class LocalFromGeodetic final : public Transform {
 public:
  static ComponentSpec spec();
  explicit LocalFromGeodetic(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  geodesy::LocalAxes axes_;
  Fields<3> position_, velocity_;
  OutputChannel channel_;
  OutputFields<4> local_position_;
  OutputFields<3> local_velocity_;
};

/// The other way: what csv does for "local" columns, for a channel of any source.
class GeodeticFromLocal final : public Transform {
 public:
  static ComponentSpec spec();
  explicit GeodeticFromLocal(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  geodesy::LocalAxes axes_;
  double down_ = 1;  // -1: the channel's counts upwards
  Fields<3> local_position_, local_velocity_;
  OutputChannel channel_;
  OutputFields<3> position_, velocity_;
};

}  // namespace binnacle::frames
