// SPDX-License-Identifier: Apache-2.0
// Healthy: the range to a beacon whose place comes on an auxiliary channel.
#pragma once

#include "faulty.hpp"

namespace faulty {

class Beacon : public Measurement {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec = Measurement::spec();
    spec.summary = "range to a beacon that makes itself known";
    spec.inputs = {{"beacon",
                    {{"x", "m", FieldKind::level, false, false, "of the beacon"},
                     {"y", "m", FieldKind::level, false, false, "of the beacon"}},
                    false,
                    "where the beacon is"}};
    spec.example = R"({"channel": "ranges", "inputs": {"beacon": "beacons"}, "blocks": {"p": "position"}})";
    spec.surroundings = R"({"sample": {"range": 360}, "inputs": {"beacon": {"x": -300, "y": -200}}})";
    return spec;
  }
  explicit Beacon(const Binding& binding)
      : Measurement(binding),
        beacons(binding.input("beacon")),
        place_x(binding.field(beacons, "x")),
        place_y(binding.field(beacons, "y")) {}
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const SampleView& place = in.auxiliary[beacons];
    if (!place.available) return Result::unsupported("no beacon has made itself known");
    return see(in.x[p][0] - place[place_x], in.x[p][1] - place[place_y], in.sample[range], out);
  }

 protected:
  Input beacons;
  Field place_x, place_y;
};

}  // namespace faulty
