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
  using Measurement::Measurement;
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context&, std::byte*, legacy::Linearization& out) const override {
    if (!auxiliary[0].available) return Result::unsupported("no beacon has made itself known");
    const double dx = x[0][0] - auxiliary[0].fields[0], dy = x[0][1] - auxiliary[0].fields[1];
    const double range = std::hypot(dx, dy);
    if (!std::isfinite(sample.fields[0]) || !(range > 0)) return Result::invalid("no range");
    out.rows = 1;
    out.residual[0] = sample.fields[0] - range;
    out.H[0](0, 0) = dx / range;
    out.H[0](0, 1) = dy / range;
    out.R(0, 0) = sigma * sigma;
    return Result::ok();
  }
};

}  // namespace faulty
