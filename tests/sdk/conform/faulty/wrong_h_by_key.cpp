// SPDX-License-Identifier: Apache-2.0
// H is −7 times what it should be, in a model that finds its beacons by a number on an auxiliary channel; it specifies no
// surroundings, so the suite has to find numbers that match.
// fails: numbers.measurement.jacobian
#include "faulty.hpp"

#include <cmath>

namespace faulty::wrong_h_by_key {

class Subject final : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "measurement";
    spec.summary = "ranges to numbered beacons";
    spec.ports = {reads("p", "vector:2:m", "position")};
    spec.fields = {field::level("id", "1").per_row().about("of the beacon"),
                   field::level("range", "m").per_row().about("to it")};
    spec.inputs = {input("beacons", {field::level("id", "1").per_row().about("of the beacon"),
                                     field::level("x", "m").per_row().about("of the beacon"),
                                     field::level("y", "m").per_row().about("of the beacon")})
                       .about("where they are")};
    spec.example = R"({"channel": "ranges", "inputs": {"beacons": "beacons"}, "blocks": {"p": "position"}})";
    return spec;
  }
  explicit Subject(const Binding& b)
      : p_(b.port("p")),
        id_(b.row_field("id")),
        range_(b.row_field("range")),
        beacons_(b.input("beacons")),
        beacon_(b.row_field(beacons_, "id")),
        x_(b.row_field(beacons_, "x")),
        y_(b.row_field(beacons_, "y")) {
    declaration_.rows(8).reads(p_).group(rows::like("range", "m"));
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const SampleView& beacons = in.auxiliary[beacons_];
    if (!beacons.available) return Result::unsupported("no beacon has made itself known");
    out.rows = 0;
    for (int i = 0; i < in.sample.rows && out.rows < 8; ++i)
      for (int k = 0; k < beacons.rows; ++k) {
        if (beacons(k, beacon_) != in.sample(i, id_) || !(in.sample(i, range_) > 0)) continue;
        const double dx = in.x[p_][0] - beacons(k, x_), dy = in.x[p_][1] - beacons(k, y_), d = std::hypot(dx, dy);
        if (!(d > 1e-6 && d < 1e9)) continue;
        const int row = out.rows++;
        out.residual[row] = in.sample(i, range_) - d;
        if (const auto H = out.H[p_]) H(row, 0) = -7 * dx / d, H(row, 1) = -7 * dy / d;
        out.R(row, row) = 0.25;
        break;
      }
    return Result::ok();
  }

 private:
  Port p_;
  RowField id_, range_;
  Input beacons_;
  RowField beacon_, x_, y_;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_h_by_key")); }

}  // namespace faulty::wrong_h_by_key
