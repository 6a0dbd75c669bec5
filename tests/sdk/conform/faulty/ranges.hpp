// SPDX-License-Identifier: Apache-2.0
// Healthy: ranges to several beacons, a row each, which bring their place along.
#pragma once

#include <cmath>

#include "faulty.hpp"

namespace faulty {

class Ranges : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec = Measurement::spec();
    spec.summary = "ranges to beacons";
    spec.fields = {{"range", "m", FieldKind::level, false, true, "to the beacon"},
                   {"x", "m", FieldKind::level, false, true, "of the beacon"},
                   {"y", "m", FieldKind::level, false, true, "of the beacon"}};
    spec.surroundings = R"({"sample": {"range": [360, 224, 500], "x": [-300, 200, 400], "y": [-200, 100, -300]}})";
    return spec;
  }
  explicit Ranges(const Binding& binding)
      : p(binding.port("p")),
        range(binding.row_field("range")),
        place_x(binding.row_field("x")),
        place_y(binding.row_field("y")),
        sigma(binding.parameters().number("sigma")) {
    declaration_.rows(most).reads(p).group(rows::like("range", "m"));
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    out.rows = 0;
    for (int i = 0; i < in.sample.rows && i < most; ++i) {
      const double dx = in.x[p][0] - in.sample(i, place_x), dy = in.x[p][1] - in.sample(i, place_y);
      const double measured = in.sample(i, range), distance = std::hypot(dx, dy);
      if (!std::isfinite(measured) || !(distance > 0) || !std::isfinite(distance)) continue;
      const int r = out.rows++;
      out.residual[r] = measured - distance;
      if (const auto H = out.H[p]) H(r, 0) = dx / distance, H(r, 1) = dy / distance;
      out.R(r, r) = sigma * sigma;
      out.row_keys[static_cast<std::size_t>(r)] = i;
    }
    return out.rows > 0 ? Result::ok() : Result::unsupported("no beacon is in range");
  }

 protected:
  static constexpr int most = 4;

  Port p;
  RowField range, place_x, place_y;
  double sigma = 0;
};

}  // namespace faulty
