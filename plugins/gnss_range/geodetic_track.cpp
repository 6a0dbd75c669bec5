// SPDX-License-Identifier: Apache-2.0
// ECEF positions of a channel in geodetic terms.
#include "geodetic_track.hpp"

#include "strapdown/earth.hpp"

namespace binnacle::gnss_range {

ComponentSpec GeodeticTrack::spec() {
  ComponentSpec spec;
  spec.type = "geodetic_track";
  spec.summary = "ECEF positions of a channel as latitude, longitude and height, as a reference for a geodetic block.";
  spec.source = "NIMA TR8350.2, 3rd edition (ellipsoid)";
  spec.inputs = {
      input("ecef", {level("x", "m", "ECEF position"), level("y", "m", "ECEF position"),
                     level("z", "m", "ECEF position"), level("vx", "m/s", "ECEF velocity").optional(),
                     level("vy", "m/s", "ECEF velocity").optional(), level("vz", "m/s", "ECEF velocity").optional()})
          .about("the track")};
  spec.example = R"json({"input": "truth"})json";
  return spec;
}

GeodeticTrack::GeodeticTrack(const Binding& binding) {
  const Input ecef = binding.input("ecef");
  position_ = binding.fields(ecef, "x", "y", "z");
  velocity_ = binding.fields(ecef, "vx", "vy", "vz");
  ChannelDeclaration channel;
  fields_ = carry_geodetic(channel);
  channel_ = declaration_.emits(std::move(channel));
}

void GeodeticTrack::on(const TransformInput& in, Emitter& emitter) const {
  const Eigen::Vector3d r = in.sample[position_];
  if (!(r.norm() > 1)) return;  // a centre has no latitude, and NaN no place
  SampleWriter& out = emitter.on(channel_);
  out.t = in.sample.t;
  const Eigen::Vector3d lla = strapdown::lla_from_ecef(r);
  out[fields_.position] = lla;
  if (velocity_.is_bound())
    out[fields_.velocity] = strapdown::C_en(lla[0], lla[1]).transpose() * Eigen::Vector3d(in.sample[velocity_]);
  emitter.emit(channel_);
}

}  // namespace binnacle::gnss_range
