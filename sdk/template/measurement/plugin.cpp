// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a measurement model, the distance to a known point.
#include <binnacle/plugin.hpp>

#include <cmath>

using namespace binnacle;

/// z = |x − p| + v, so r = z − |x̂ − p| and H = (x̂ − p)ᵀ / |x̂ − p|.
class Range final : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "The distance from a point in the plane to a beacon.";
    spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 6.1";
    spec.parameters = {parameter::vector("beacon", "m", 2).required().about("where the beacon stands: north, east"),
                       parameter::number("sigma", "m").above(0).defaults("\"0.5 m\"").about("of the white noise")};
    spec.ports = {reads("position", "vector:2:m").about("of the receiver: north, east")};
    spec.fields = {field::level("range", "m").about("the measured distance")};
    spec.example = R"json({"channel": "ranges", "blocks": {"position": "position"}, "beacon": ["0 m", "100 m"]})json";
    spec.surroundings = R"json({"sample": {"range": 99}})json";
    return spec;
  }

  explicit Range(const Binding& b)
      : position_(b.port("position")),
        range_(b.field("range")),
        beacon_(b.parameters().vector("beacon")),
        variance_(std::pow(b.parameters().number("sigma"), 2)) {
    declaration_.rows(1).reads(position_).group(rows::these("range", 1, "m"));
  }

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const double range = in.sample[range_];
    if (!(range >= 0 && std::isfinite(range))) return Result::invalid("a range is a finite number and not negative");
    const Eigen::Vector2d d = in.x[position_].as<2>() - beacon_;
    const double distance = d.norm();
    if (distance < 1) return Result::unsupported("closer than 1 m to the beacon, where the direction means nothing");
    out.rows = 1;
    out.residual[0] = range - distance;
    if (auto H = out.H[position_]) H.as<1, 2>() = d.transpose() / distance;
    out.R(0, 0) = variance_;
    return Result::ok();
  }

 private:
  Port position_;
  Field range_;
  Eigen::Vector2d beacon_;  // m
  double variance_;         // m²
};

BINNACLE_TYPES("@NAME@");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<Range>(); }
