// SPDX-License-Identifier: Apache-2.0
// The fields that simulators declare.
#include "simulation/fields.hpp"

#include <utility>

namespace binnacle::simulation {

FieldSpec level(std::string name, std::string unit, std::string text) {
  return {std::move(name), std::move(unit), FieldKind::level, false, false, std::move(text)};
}

Triad triad(const std::string& prefix, const std::string& unit, const std::string& text) {
  return {level(prefix + "x", unit, text + ", body x (forward)"), level(prefix + "y", unit, text + ", body y (right)"),
          level(prefix + "z", unit, text + ", body z (down)")};
}

Triad position_fields() {
  return {level("lat", "rad", "geodetic latitude, WGS-84"), level("lon", "rad", "longitude, east positive"),
          level("height", "m", "height above the ellipsoid")};
}

Triad velocity_fields() {
  return {level("vn", "m/s", "velocity over ground, north"), level("ve", "m/s", "velocity over ground, east"),
          level("vd", "m/s", "velocity over ground, down")};
}

Triad attitude_fields() {
  return {level("roll", "rad", "roll, right side down positive"), level("pitch", "rad", "pitch, nose up positive"),
          level("yaw", "rad", "heading of body x, from north to east")};
}

ParameterSpec sigmas(std::string name, const std::string& unit, const std::string& defaults, const std::string& text) {
  return parameter::vector(std::move(name), unit, 3).at_least(0).defaults(defaults).about(text);
}

ImuFields carry_imu(ChannelDeclaration& channel, bool emits_rates) {
  const auto carry = [&](Triad fields) {
    for (FieldSpec& field : fields) field.kind = emits_rates ? FieldKind::rate : FieldKind::increment;
    return channel.carries(std::move(fields));
  };
  const auto w = carry(triad("w", emits_rates ? "rad/s" : "rad", "angular rate against inertial space"));
  return {w, carry(triad("f", emits_rates ? "m/s^2" : "m/s", "specific force"))};
}

std::vector<NamedUnit> navigation_covariance() {
  std::vector<NamedUnit> components;
  for (const auto& [block, unit] : {std::pair{"position.", "m"}, {"velocity.", "m/s"}, {"attitude.", "rad"}})
    for (const char* axis : {"north", "east", "down"}) components.push_back({std::string(block) + axis, unit});
  return components;
}

}  // namespace binnacle::simulation
