// SPDX-License-Identifier: Apache-2.0
// A geodetic position on the WGS-84 ellipsoid.
#include "position_block.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "binnacle/view.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::navigation {

ComponentSpec PositionBlock::spec() {
  ComponentSpec spec;
  spec.type = "position";
  spec.former_names = {"phi_error/position"};
  spec.summary = "Latitude, longitude and height on WGS-84; its error in metres north, east, down.";
  spec.source = "NIMA TR8350.2, 3rd edition (ellipsoid); paper 003, equation (1)";
  spec.kind = "position";
  spec.example = R"json({"init": {"lat": "37.4 deg", "lon": "126.9 deg", "height": "60 m"},
    "sigma": ["5 m", "5 m", "10 m"]})json";
  return spec;
}

PositionBlock::PositionBlock(const Binding& /*binding*/) {
  declaration_.kind = "position";
  declaration_.stored_size = 3;
  declaration_.error = {{"north", "m"}, {"east", "m"}, {"down", "m"}};
  declaration_.outputs = {{"lat", "rad", "deg", false, false, "geodetic latitude"},
                          {"lon", "rad", "deg", true, false, "longitude, east positive"},
                          {"height", "m", "", false, false, "height above the ellipsoid"}};
  // The height on its own, by its magnitude: of which papers give the mean.
  declaration_.norms = {{"horizontal", {0, 1}}, {"height", {2}}};
}

void PositionBlock::plus(ConstVectorView x, ConstVectorView delta, VectorView result) const {
  result.as<3>() = strapdown::position_plus(x.as<3>(), delta.as<3>());
}

void PositionBlock::minus(ConstVectorView y, ConstVectorView x, VectorView delta) const {
  delta.as<3>() = strapdown::position_minus(y.as<3>(), x.as<3>());
}

void PositionBlock::read(ConstVectorView x, VectorView outputs) const { outputs.as<3>() = x.as<3>(); }

Result PositionBlock::write(ConstVectorView outputs, VectorView x) const {
  const auto [lat, lon, height] = std::array{outputs[0], outputs[1], outputs[2]};
  if (!std::isfinite(lat) || !std::isfinite(lon) || !std::isfinite(height))
    return Result::invalid("latitude, longitude or height is not finite");
  if (std::abs(lat) > std::numbers::pi / 2) return Result::invalid("the latitude lies beyond a pole");
  if (std::abs(lon) > 2.0 * std::numbers::pi) return Result::invalid("the longitude is more than one turn");
  x[0] = lat;
  x[1] = std::abs(lon) <= std::numbers::pi ? lon : std::remainder(lon, 2.0 * std::numbers::pi);
  x[2] = height;
  return Result::ok();
}

bool PositionBlock::output_jacobian(ConstVectorView x, MatrixView J) const {
  J.as<3, 3>() = strapdown::position_plus_jacobian(x.as<3>()).asDiagonal();
  return true;
}

}  // namespace binnacle::navigation
