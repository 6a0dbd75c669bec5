// SPDX-License-Identifier: Apache-2.0
// A process model with an auxiliary channel: a balloon goes where the wind goes, and a station reports the wind.
#pragma once

#include <binnacle/plugin.hpp>

#include <cmath>

/// x' = w + n, n white noise of density q². The wind w is the station's latest report; until the first, it is calm.
class Drift final : public binnacle::ProcessModel {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    ComponentSpec spec;
    spec.type = "drift";
    spec.summary = "A balloon that goes with the wind, which a station reports.";
    spec.parameters = {
        parameter::number("q", "m/sqrt(s)").at_least(0).defaults("1").about("of the random walk besides")};
    spec.ports = {advances("position", "vector:2:m").about("of the balloon: north, east")};
    spec.inputs = {input("wind", {field::level("north", "m/s").about("where it blows to"),
                                  field::level("east", "m/s").about("likewise")})
                       .about("as the station reports it")};
    spec.example = R"json({"blocks": {"position": "position"}, "inputs": {"wind": "wind"}, "q": 2})json";
    spec.surroundings = R"json({"inputs": {"wind": {"north": 3, "east": -5}}})json";
    return spec;
  }

  explicit Drift(const binnacle::Binding& b)
      : position_(b.port("position")),
        wind_(b.input("wind")),
        north_(b.field(wind_, "north")),
        east_(b.field(wind_, "east")),
        q_(b.parameters().number("q")),
        noise_(declaration_.adds_noise(position_, position_, binnacle::Structure::diagonal)) {}

  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    const binnacle::SampleView& report = in.auxiliary[wind_];
    Eigen::Vector2d wind = Eigen::Vector2d::Zero();
    if (report.available)
      wind << report[north_], report[east_];
    else
      in.notes.leave("no wind has been reported yet, it is taken as calm");
    if (!wind.allFinite()) return binnacle::Result::failed("the reported wind is not a number");
    out.x[position_].as<2>() = in.x[position_].as<2>() + wind * in.step.dt;
    if (const auto Qd = out.Qd[noise_]) Qd.diagonal<2>().setConstant(q_ * q_ * in.step.dt);
    return binnacle::Result::ok();
  }

 private:
  binnacle::Port position_;
  binnacle::Input wind_;
  binnacle::Field north_, east_;
  double q_;  // m/√s
  binnacle::QBlock noise_;
};
