// SPDX-License-Identifier: Apache-2.0
// Position and velocity in earth-centred, earth-fixed axes.
#include "earth_blocks.hpp"

namespace binnacle::gnss_range {

ComponentSpec EcefPosition::spec() {
  ComponentSpec spec;
  spec.type = "ecef_position";
  spec.summary = "Position in earth-centred, earth-fixed axes, WGS-84.";
  spec.source = "paper 003, section 4.2; NIMA TR8350.2, 3rd edition";
  spec.kind = "position.ecef";
  spec.example = R"json({"init": {"x": -3976219, "y": 3382371, "z": 3652511}, "sigma": "100 m"})json";
  return spec;
}

EcefPosition::EcefPosition(const Binding& /*binding*/) {
  declaration_.kind = "position.ecef";
  declaration_.stored_size = 3;
  declaration_.error = {{"x", "m"}, {"y", "m"}, {"z", "m"}};
  declaration_.outputs = {{"x", "m", "", false, false, "towards the equator at Greenwich"},
                          {"y", "m", "", false, false, "towards the equator at 90 deg east"},
                          {"z", "m", "", false, false, "towards the north pole"}};
  declaration_.norms = {{"distance", {0, 1, 2}}};
}

ComponentSpec EcefVelocity::spec() {
  ComponentSpec spec;
  spec.type = "ecef_velocity";
  spec.summary = "Velocity relative to the earth in earth-centred, earth-fixed axes.";
  spec.source = "paper 003, section 4.2";
  spec.kind = "velocity.ecef";
  spec.example = R"json({"init": {"vx": 0, "vy": 0, "vz": 0}, "sigma": "10 m/s"})json";
  return spec;
}

EcefVelocity::EcefVelocity(const Binding& /*binding*/) {
  declaration_.kind = "velocity.ecef";
  declaration_.stored_size = 3;
  declaration_.error = {{"x", "m/s"}, {"y", "m/s"}, {"z", "m/s"}};
  declaration_.outputs = {{"vx", "m/s", "", false, false, "along x"},
                          {"vy", "m/s", "", false, false, "along y"},
                          {"vz", "m/s", "", false, false, "along z"}};
  declaration_.norms = {{"speed", {0, 1, 2}}};
}

}  // namespace binnacle::gnss_range
