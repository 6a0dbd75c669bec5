// SPDX-License-Identifier: Apache-2.0
// Healthy: ranges to several beacons, a row each, which bring their place along.
#pragma once

#include "faulty.hpp"

namespace faulty {

class Ranges : public Measurement {
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
  explicit Ranges(const Binding& binding) : Measurement(binding) {
    declared.max_rows = 4;
    declared.groups = {{"range", 0, 0, "m", -1}};
  }
  Result linearize(const SampleView& sample, const SampleView*, const double* const* x, const legacy::Context&,
                   std::byte*, legacy::Linearization& out) const override {
    out.rows = 0;
    for (int i = 0; i < sample.rows && i < 4; ++i) {
      const double* row = sample.row_fields + 3 * i;
      const double dx = x[0][0] - row[1], dy = x[0][1] - row[2], range = std::hypot(dx, dy);
      if (!std::isfinite(row[0]) || !(range > 0) || !std::isfinite(range)) continue;
      const int r = out.rows++;
      out.residual[r] = row[0] - range;
      out.H[0](r, 0) = dx / range;
      out.H[0](r, 1) = dy / range;
      out.R(r, r) = sigma * sigma;
      out.row_keys[r] = i;
    }
    return out.rows > 0 ? Result::ok() : Result::unsupported("no beacon is in range");
  }
};

}  // namespace faulty
