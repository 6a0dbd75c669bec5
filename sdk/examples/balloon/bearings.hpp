// SPDX-License-Identifier: Apache-2.0
// A measurement model with rows: bearings to landmarks, a row each, and a list of landmarks on an auxiliary channel.
#pragma once

#include <binnacle/plugin.hpp>

#include <cmath>
#include <cstdint>
#include <numbers>

/// z = atan2(d_e, d_n) + v with d = m − x, m the landmark's place: r = z − ẑ within half a turn, H = (d_e, −d_n)/|d|².
class Bearings final : public binnacle::MeasurementModel {
 public:
  static constexpr int most = 16;  // rows of a sample

  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    ComponentSpec spec;
    spec.type = "bearings";
    spec.summary = "Bearings to landmarks whose places come on an auxiliary channel.";
    spec.parameters = {parameter::number("sigma", "rad").above(0).defaults("\"0.5 deg\"").about("of a bearing")};
    spec.ports = {reads("position", "vector:2:m").about("of the observer: north, east")};
    spec.fields = {field::level("id", "1").per_row().about("of the landmark"),
                   field::level("bearing", "rad").per_row().about("clockwise from north")};
    spec.inputs = {input("landmarks", {field::level("number", "1").per_row().about("its id"),
                                       field::level("north", "m").per_row().about("of it"),
                                       field::level("east", "m").per_row().about("of it")})
                       .about("all that there are, a row each")};
    spec.example = R"json({"channel": "sightings", "inputs": {"landmarks": "landmarks"},
      "blocks": {"position": "position"}})json";
    spec.surroundings = R"json({
      "blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "init": {"x0": 100, "x1": -50}, "sigma": 5}},
      "inputs": {"landmarks": {"number": [1, 2, 7], "north": [2000, -900, 300], "east": [500, 1500, -2500]}},
      "sample": {"id": [1, 7], "bearing": [0.28, -1.49]}})json";
    return spec;
  }

  explicit Bearings(const binnacle::Binding& b)
      : position_(b.port("position")),
        id_(b.row_field("id")),
        bearing_(b.row_field("bearing")),
        landmarks_(b.input("landmarks")),
        number_(b.row_field(landmarks_, "number")),
        north_(b.row_field(landmarks_, "north")),
        east_(b.row_field(landmarks_, "east")),
        variance_(std::pow(b.parameters().number("sigma"), 2)) {
    declaration_.rows(most).reads(position_).group(binnacle::rows::like("bearing", "rad"));
  }

  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    const binnacle::SampleView& landmarks = in.auxiliary[landmarks_];
    if (!landmarks.available) return binnacle::Result::unsupported("the landmarks are not known yet");
    if (in.sample.rows > most) return binnacle::Result::invalid("more bearings than the model takes");
    out.rows = 0;
    for (int i = 0; i < in.sample.rows; ++i) {
      const double id = in.sample(i, id_), z = in.sample(i, bearing_);
      const int mark = row_of(landmarks, id);
      if (mark < 0 || !std::isfinite(z)) {
        in.notes.leave("a bearing is not a number, or to a landmark that is not listed: left out");
        continue;
      }
      const Eigen::Vector2d d =
          Eigen::Vector2d(landmarks(mark, north_), landmarks(mark, east_)) - in.x[position_].as<2>();
      if (!(d.norm() >= 1 && d.norm() < 1e7)) continue;  // too near for a direction, or out of this world
      const int r = out.rows++;
      out.residual[r] = std::remainder(z - std::atan2(d[1], d[0]), 2 * std::numbers::pi);
      if (const auto H = out.H[position_]) H.as().row(r) = Eigen::RowVector2d(d[1], -d[0]) / d.squaredNorm();
      out.R(r, r) = variance_;
      out.row_keys[static_cast<std::size_t>(r)] = std::llround(id);
    }
    return binnacle::Result::ok();
  }

 private:
  /// −1: it is not listed.
  int row_of(const binnacle::SampleView& landmarks, double id) const {
    for (int i = 0; i < landmarks.rows; ++i)
      if (std::abs(landmarks(i, number_) - id) < 0.5) return i;
    return -1;
  }

  binnacle::Port position_;
  binnacle::RowField id_, bearing_;
  binnacle::Input landmarks_;
  binnacle::RowField number_, north_, east_;
  double variance_;  // rad²
};
