// SPDX-License-Identifier: Apache-2.0
// A place that is known: the reference of a receiver that stands still.
#include "surveyed_point.hpp"

#include <algorithm>

#include "gnss/channels.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::gnss_range {

ComponentSpec SurveyedPoint::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "surveyed_point";
  spec.summary = "A known position at the times of another channel, as the reference of a static antenna.";
  spec.source = "NIMA TR8350.2, 3rd edition (ellipsoid)";
  spec.parameters = {vector("ecef", "m", 3).about("ECEF position; alternative to lat, lon and height"),
                     number("lat", "rad").at_least(-M_PI / 2).at_most(M_PI / 2).about("geodetic latitude, WGS-84"),
                     number("lon", "rad").about("longitude, east positive"),
                     number("height", "m").about("height above the ellipsoid")};
  spec.inputs = {input("when", {field::level("satellite", "1").per_row().about("an observation channel")})
                     .about("channel with the epochs")};
  spec.example = R"json({"input": "gnss.obs", "ecef": [-3976219.1, 3382371.6, 3652511.2]})json";
  return spec;
}

SurveyedPoint::SurveyedPoint(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  const bool is_geodetic = parameters.has("lat") && parameters.has("lon") && parameters.has("height");
  const bool has_some = parameters.has("lat") || parameters.has("lon") || parameters.has("height");
  if (parameters.has("ecef") == has_some || is_geodetic != has_some)
    throw ComponentError("give 'ecef', or 'lat', 'lon' and 'height'");
  if (is_geodetic) {
    lla_ = {parameters.number("lat"), parameters.number("lon"), parameters.number("height")};
    ecef_ = strapdown::ecef_from_lla(lla_);
  } else {
    ecef_ = parameters.vector("ecef");
    lla_ = strapdown::lla_from_ecef(ecef_);
  }
  ChannelDeclaration channel;
  ecef_fields_ = carry_ecef(channel);
  geodetic_fields_ = carry_geodetic(channel);
  channel_ = declaration_.emits(std::move(channel));
}

void SurveyedPoint::on(const TransformInput& in, Emitter& emitter) const {
  SampleWriter& out = emitter.on(channel_);
  out.t = in.sample.t;
  out[ecef_fields_.position] = ecef_;
  out[ecef_fields_.velocity].setZero();
  out[geodetic_fields_.position] = lla_;
  out[geodetic_fields_.velocity].setZero();
  emitter.emit(channel_);
}

}  // namespace binnacle::gnss_range
