// SPDX-License-Identifier: Apache-2.0
// Distances to anchors, and differences of them: ultra-wideband, acoustic transponders.
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "binnacle/eigen.hpp"
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

/// Anchors, and what a signal's way to each measures: |r − r_a| + b_a + n + d. d: with the probability `blocked` an
/// exponential deviate of mean `detour`, else 0: a way by a wall is too long, never too short.
class Ways {
 public:
  Ways(const Parameters& parameters, const std::string& sensor)
      : noise_(parameters.number("noise")),
        bias_(parameters.number("bias")),
        detour_(parameters.number("detour")),
        reach_(parameters.has("reach") ? parameters.number("reach") : std::numeric_limits<double>::infinity()),
        lever_arm_(parameters.vector("lever_arm")) {
    for (const auto& [name, value] : parameters.members("anchors")) {
      const Parameters anchor(value);
      const Vector3d lla(anchor.number("lat"), anchor.number("lon"), anchor.number("height"));
      anchors_.push_back({number_of(name, sensor), name, geodesy::ecef_from_lla(lla),
                          anchor.has("blocked") ? anchor.number("blocked") : parameters.number("blocked")});
    }
    if (anchors_.empty()) throw ComponentError("no anchor is listed", "/" + sensor + "/anchors");
  }
  int count() const { return static_cast<int>(anchors_.size()); }
  /// Of the anchors the one of this number comes first. False: it is not listed.
  bool put_first(double key) {
    const auto found = std::find_if(anchors_.begin(), anchors_.end(), [&](const Anchor& a) { return a.key == key; });
    if (found == anchors_.end()) return false;
    std::rotate(anchors_.begin(), found, found + 1);
    return true;
  }
  std::vector<SlowError> errors() const {
    std::vector<SlowError> errors;
    for (const Anchor& anchor : anchors_)
      errors.push_back({"bias_" + anchor.name, "m", "what ranges to anchor " + anchor.name + " have too much", bias_});
    return errors;
  }
  /// take(key, way [m]) of each anchor within reach, in their order. All have their deviates drawn.
  template <class Take>
  void each(const Truth& truth, std::span<const double> e, Noise& noise, const Take& take) const {
    const Vector3d r = geodesy::ecef_from_lla(position_at(truth, lever_arm_));
    for (std::size_t i = 0; i < anchors_.size(); ++i) {
      const double white = noise_ * noise.next(), detour = noise.exponential(detour_, anchors_[i].blocked);
      const double range = (r - anchors_[i].r).norm();
      if (range <= reach_) take(anchors_[i].key, range + e[i] + white + detour);
    }
  }

 private:
  static double number_of(const std::string& name, const std::string& sensor) {
    if (name.empty() || name.size() > 15 || name.find_first_not_of("0123456789") != std::string::npos)
      throw ComponentError("an anchor is listed by its whole number: \"105\"", "/" + sensor + "/anchors/" + name);
    return std::stod(name);
  }

  double noise_, bias_, detour_, reach_;
  Vector3d lever_arm_;
  std::vector<Anchor> anchors_;
};

/// A row for each anchor.
class Range final : public Sensor {
 public:
  explicit Range(const Parameters& parameters) : ways_(parameters, "range") {}
  void declare(ChannelDeclaration& channel) override {
    anchor_ = channel.carries_per_row(field::level("anchor", "1").about("its number"));
    range_ = channel.carries_per_row(field::level("range", "m").about("distance to it, with errors"));
    channel.max_rows = ways_.count();
  }
  std::vector<SlowError> errors() const override { return ways_.errors(); }
  void measure(const Truth& truth, std::span<const double> e, Noise& noise, SampleWriter& out) const override {
    out.rows = 0;
    ways_.each(truth, e, noise, [&](double key, double way) {
      out(out.rows, anchor_) = key;
      out(out.rows, range_) = way;
      ++out.rows;
    });
  }

 private:
  Ways ways_;
  OutputRowField anchor_, range_;
};

/// Times of arrival of the vehicle's signal at anchors whose clocks agree: a row for each anchor but the reference, its
/// way less the reference's, so that the rows share what the reference has of errors. The instant of sending is in none.
class RangeDifference final : public Sensor {
 public:
  explicit RangeDifference(const Parameters& parameters)
      : ways_(parameters, "range_difference"), reference_key_(static_cast<double>(parameters.integer("reference"))) {
    if (ways_.count() < 2)
      throw ComponentError("a difference needs two anchors; one is listed", "/range_difference/anchors");
    if (!ways_.put_first(reference_key_))
      throw ComponentError("anchor " + std::to_string(parameters.integer("reference")) + " is none of 'anchors'",
                           "/range_difference/reference");
  }
  void declare(ChannelDeclaration& channel) override {
    anchor_ = channel.carries_per_row(field::level("anchor", "1").about("its number"));
    reference_ = channel.carries_per_row(
        field::level("reference", "1").about("number of the reference anchor, whose distance is subtracted"));
    difference_ = channel.carries_per_row(
        field::level("range_difference", "m").about("distance to the anchor less that to the reference, with errors"));
    channel.max_rows = ways_.count() - 1;
  }
  std::vector<SlowError> errors() const override { return ways_.errors(); }
  void measure(const Truth& truth, std::span<const double> e, Noise& noise, SampleWriter& out) const override {
    out.rows = 0;
    std::optional<double> reference;
    ways_.each(truth, e, noise, [&](double key, double way) {
      if (key == reference_key_) {
        reference = way;  // the first, if it is within reach
      } else if (reference) {
        out(out.rows, anchor_) = key;
        out(out.rows, reference_) = reference_key_;
        out(out.rows, difference_) = way - *reference;
        ++out.rows;
      }
    });
  }

 private:
  Ways ways_;
  double reference_key_;
  OutputRowField anchor_, reference_, difference_;
};

/// What both are made of.
std::vector<ParameterSpec> way_parameters() {
  using namespace parameter;
  const auto share = [](const char* text) { return number("blocked", "1").at_least(0).at_most(1).about(text); };
  return {map("anchors", object("anchor", {number("lat", "rad").required().about("geodetic latitude, WGS-84"),
                                           number("lon", "rad").required().about("longitude, east positive"),
                                           number("height", "m").required().about("height above the ellipsoid"),
                                           share("'blocked' for the ranges of this anchor")}))
              .required()
              .about("positions of the anchors by number"),
          number("noise", "m").at_least(0).defaults("0").about("1-sigma of the white noise of a range"),
          number("bias", "m").at_least(0).defaults("0").about("1-sigma of an anchor's bias, drawn once per run"),
          share("fraction of the ranges that are measured over a reflection").defaults("0"),
          number("detour", "m")
              .at_least(0)
              .defaults("0")
              .about("mean excess length of such a range; exponential distribution"),
          number("reach", "m").above(0).about("largest range; anchors beyond it have no row"),
          lever_arm_parameter()};
}

}  // namespace

SensorKind range() {
  return {"range",
          sensor_object("range", way_parameters(),
                        "ranges to anchors on the channel NAME.range: anchor, range; a row for each anchor"),
          [](const Parameters& parameters) { return std::make_unique<Range>(parameters); }};
}

SensorKind range_difference() {
  std::vector<ParameterSpec> own = way_parameters();
  own.push_back(
      parameter::integer("reference")
          .required()
          .about(
              "number of the reference anchor, whose distance is subtracted; there are no rows if it is out of reach"));
  return {"range_difference",
          sensor_object("range_difference", std::move(own),
                        "time differences of arrival (TDOA), on the channel NAME.range_difference: anchor, reference, "
                        "range_difference; 'noise' and 'bias' are those of one anchor's arrival"),
          [](const Parameters& parameters) { return std::make_unique<RangeDifference>(parameters); }};
}

}  // namespace binnacle::aiding_simulator
