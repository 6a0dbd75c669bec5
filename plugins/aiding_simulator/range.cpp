// SPDX-License-Identifier: Apache-2.0
// Distances to anchors: ultra-wideband, acoustic transponders.
#include <cmath>
#include <limits>

#include "binnacle/geodesy.hpp"
#include "sensor.hpp"

namespace binnacle::aiding_simulator {

namespace {

using Eigen::Vector3d;

struct Anchor {
  double key;
  std::string name;
  Vector3d r;      // m, ECEF
  double blocked;  // share of its ranges that come by a detour
};

/// z = |r − r_a| + b_a + n + d, a row for each anchor. d: with the probability `blocked` an exponential deviate of mean
/// `detour`, else 0: a range that comes by way of a wall is too long, never too short.
class Range final : public Sensor {
 public:
  explicit Range(const Parameters& parameters)
      : noise_(parameters.number("noise")),
        bias_(parameters.number("bias")),
        detour_(parameters.number("detour")),
        reach_(parameters.has("reach") ? parameters.number("reach") : std::numeric_limits<double>::infinity()),
        lever_arm_(parameters.vector("lever_arm")) {
    for (const auto& [name, value] : parameters.members("anchors")) {
      const Parameters anchor(value);
      const Vector3d lla(anchor.number("lat"), anchor.number("lon"), anchor.number("height"));
      anchors_.push_back({number_of(name), name, geodesy::ecef_from_lla(lla),
                          anchor.has("blocked") ? anchor.number("blocked") : parameters.number("blocked")});
    }
    if (anchors_.empty()) throw ComponentError("no anchor is listed", "/range/anchors");
  }
  void declare(ChannelDeclaration& channel) override {
    anchor_ = channel.carries_per_row(field::level("anchor", "1").about("its number"));
    range_ = channel.carries_per_row(field::level("range", "m").about("distance to it, with errors"));
    channel.max_rows = static_cast<int>(anchors_.size());
  }
  std::vector<SlowError> errors() const override {
    std::vector<SlowError> errors;
    for (const Anchor& anchor : anchors_)
      errors.push_back({"bias_" + anchor.name, "m", "what ranges to anchor " + anchor.name + " have too much", bias_});
    return errors;
  }
  void measure(const Truth& truth, std::span<const double> e, Noise& noise, SampleWriter& out) const override {
    const Vector3d r = geodesy::ecef_from_lla(position_at(truth, lever_arm_));
    out.rows = 0;
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      const double white = noise_ * noise.next(), detour = noise.exponential(detour_, anchors_[i].blocked);
      const double range = (r - anchors_[i].r).norm();
      if (range > reach_) continue;
      out(out.rows, anchor_) = anchors_[i].key;
      out(out.rows, range_) = range + e[i] + white + detour;
      ++out.rows;
    }
  }

 private:
  static double number_of(const std::string& name) {
    if (name.empty() || name.size() > 15 || name.find_first_not_of("0123456789") != std::string::npos)
      throw ComponentError("an anchor is listed by its whole number: \"105\"", "/range/anchors/" + name);
    return std::stod(name);
  }

  double noise_, bias_, detour_, reach_;
  Vector3d lever_arm_;
  std::vector<Anchor> anchors_;
  OutputRowField anchor_, range_;
};

}  // namespace

SensorKind range() {
  using namespace parameter;
  const auto share = [](const char* text) { return number("blocked", "1").at_least(0).at_most(1).about(text); };
  return {"range",
          sensor_object(
              "range",
              {map("anchors", object("anchor", {number("lat", "rad").required().about("geodetic latitude, WGS-84"),
                                                number("lon", "rad").required().about("longitude, east positive"),
                                                number("height", "m").required().about("above the ellipsoid"),
                                                share("of this anchor's ranges")}))
                   .required()
                   .about("by number: where it is"),
               number("noise", "m").at_least(0).defaults("0").about("1-sigma of a range, white"),
               number("bias", "m").at_least(0).defaults("0").about("1-sigma of an anchor's bias, drawn once a run"),
               share("share of the ranges that come by way of a wall").defaults("0"),
               number("detour", "m")
                   .at_least(0)
                   .defaults("0")
                   .about("by how much such a range is too long: mean of an "
                          "exponential distribution"),
               number("reach", "m").above(0).about("an anchor further away has no row"), lever_arm_parameter()},
              "ranges to anchors on the channel NAME.range: anchor, range; a row for each anchor"),
          [](const Parameters& parameters) { return std::make_unique<Range>(parameters); }};
}

}  // namespace binnacle::aiding_simulator
