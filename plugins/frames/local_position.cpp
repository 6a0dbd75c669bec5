// SPDX-License-Identifier: Apache-2.0
#include "local_position.hpp"

namespace binnacle::frames {

namespace {

using field::level;

const char* const sources =
    "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 2.1";

std::vector<FieldSpec> geodetic_fields() {
  return {level("lat", "rad").about("geodetic latitude"), level("lon", "rad").about("longitude, east positive"),
          level("height", "m").about("height above the ellipsoid")};
}
FieldSpec velocity_field(const char* name, const char* text) { return level(name, "m/s").optional().about(text); }

}  // namespace

ComponentSpec LocalFromGeodetic::spec() {
  ComponentSpec spec;
  spec.type = "local_from_geodetic";
  spec.summary = "Positions of a channel in local north, east, down of an origin.";
  spec.source = sources;
  spec.parameters = {parameter::origin()};
  auto fields = geodetic_fields();
  fields.push_back(velocity_field("vn", "velocity over ground, north"));
  fields.push_back(velocity_field("ve", "velocity over ground, east"));
  fields.push_back(velocity_field("vd", "velocity over ground, down"));
  spec.inputs = {input("geodetic", std::move(fields)).about("the track")};
  spec.example = R"json({"input": "truth", "origin": {"lat": "49.01 deg", "lon": "8.43 deg", "height": "115 m"}})json";
  return spec;
}

LocalFromGeodetic::LocalFromGeodetic(const Binding& binding)
    : axes_(local_axes_of(binding.parameters(), "local coordinates")) {
  const Input track = binding.input("geodetic");
  position_ = binding.fields(track, "lat", "lon", "height");
  velocity_ = binding.fields(track, "vn", "ve", "vd");
  ChannelDeclaration channel;
  local_position_ = channel.carries(level("north", "m").about("local position, north of the origin"),
                                    level("east", "m"), level("down", "m"), level("up", "m").about("-down"));
  local_velocity_ = channel.carries(level("v_north", "m/s").about("local velocity, north"), level("v_east", "m/s"),
                                    level("v_down", "m/s"));
  channel_ = declaration_.emits(std::move(channel));
}

void LocalFromGeodetic::on(const TransformInput& in, Emitter& emitter) const {
  const Eigen::Vector3d lla = in.sample[position_];
  SampleWriter& out = emitter.on(channel_);
  out.t = in.sample.t;
  const Eigen::Vector3d p_l = axes_.ned_from_lla(lla);
  out[local_position_] << p_l, -p_l[2];
  if (velocity_.is_bound()) out[local_velocity_] = axes_.C_nl(lla).transpose() * Eigen::Vector3d(in.sample[velocity_]);
  emitter.emit(channel_);
}

ComponentSpec GeodeticFromLocal::spec() {
  ComponentSpec spec;
  spec.type = "geodetic_from_local";
  spec.summary = "Local positions of a channel as latitude, longitude and height, for a measurement or a reference.";
  spec.source = sources;
  spec.parameters = {parameter::origin()};
  spec.parameters.push_back(parameter::choice("vertical", {"down", "up"})
                                .defaults("\"down\"")
                                .about("up: the channel's 'down' is positive upwards; \"fields\" gives its name"));
  spec.inputs = {input("local", {level("north", "m").about("local position, north of the origin"),
                                 level("east", "m").about("local position, east of the origin"),
                                 level("down", "m").about("local position, down of the origin, or up"),
                                 velocity_field("v_north", "local velocity, north"),
                                 velocity_field("v_east", "local velocity, east"),
                                 velocity_field("v_down", "local velocity, down, or up")})
                     .about("the track")};
  spec.example = R"json({"input": "truth", "origin": {"lat": "49.01 deg", "lon": "8.43 deg", "height": "115 m"}})json";
  return spec;
}

GeodeticFromLocal::GeodeticFromLocal(const Binding& binding)
    : axes_(local_axes_of(binding.parameters(), "local coordinates")) {
  const Input track = binding.input("local");
  local_position_ = binding.fields(track, "north", "east", "down");
  local_velocity_ = binding.fields(track, "v_north", "v_east", "v_down");
  if (binding.parameters().text("vertical") == "up") down_ = -1;
  ChannelDeclaration channel;
  position_ = channel.carries(level("lat", "rad").about("geodetic latitude"),
                              level("lon", "rad").about("longitude, east positive"),
                              level("height", "m").about("height above the ellipsoid"));
  velocity_ =
      channel.carries(level("vn", "m/s").about("velocity over ground, north"), level("ve", "m/s"), level("vd", "m/s"));
  channel_ = declaration_.emits(std::move(channel));
}

void GeodeticFromLocal::on(const TransformInput& in, Emitter& emitter) const {
  const Eigen::Vector3d to_ned{1, 1, down_};
  const Eigen::Vector3d lla = axes_.lla_from_ned(to_ned.cwiseProduct(Eigen::Vector3d(in.sample[local_position_])));
  SampleWriter& out = emitter.on(channel_);
  out.t = in.sample.t;
  out[position_] = lla;
  if (local_velocity_.is_bound())
    out[velocity_] = axes_.C_nl(lla) * to_ned.cwiseProduct(Eigen::Vector3d(in.sample[local_velocity_]));
  emitter.emit(channel_);
}

}  // namespace binnacle::frames
