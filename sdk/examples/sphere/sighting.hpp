// SPDX-License-Identifier: Apache-2.0
// A direction that a sensor sees.
#pragma once

#include <binnacle/plugin.hpp>

#include <cmath>

#include "s2.hpp"

/// z = x ⊞ v with v the same in all directions: a star tracker's line of sight, an accelerometer at rest. The length of
/// what is measured does not matter. The residual is taken in axes at z, which do not move with the estimate:
///
///     r = −(x̂ ⊟ z),   H = ∂(x̂ ⊟ z)/∂δ,   R = σ² I
///
/// In those at x̂ (r = z ⊟ x̂), H would need the derivative of those axes.
class Sighting final : public binnacle::MeasurementModel {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    ComponentSpec spec;
    spec.type = "sighting";
    spec.summary = "A direction, measured: a vector of which the length does not matter.";
    spec.source = "Hertzberg, Wagner, Frese, Schroeder, Integrating generic sensor fusion algorithms, 2013, section 3";
    spec.parameters = {
        parameter::number("sigma", "rad").above(0).at_most(1).required().about("of the white noise, in each axis")};
    spec.ports = {reads("direction", "direction", "the direction that is seen, in axes of the body")};
    for (const char* axis : {"x", "y", "z"}) spec.fields.push_back(field::level(axis, "*").about("body axis"));
    spec.example = R"json({"channel": "seen", "blocks": {"direction": "down"}, "sigma": "0.5 deg"})json";
    spec.surroundings = R"json({"blocks": {
      "down": {"type": "direction", "init": {"x": 0, "y": 0.6, "z": 0.8}, "sigma": "2 deg"}}})json";
    return spec;
  }

  explicit Sighting(const binnacle::Binding& b)
      : direction_(b.port("direction")),
        seen_(b.fields("x", "y", "z")),
        variance_(std::pow(b.parameters().number("sigma"), 2)) {
    declaration_.rows(2).reads(direction_).group(binnacle::rows::these("direction", 2, "rad"));
  }

  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    using binnacle::Result;
    s2::Vector3 z = in.sample[seen_];
    const double length = z.stableNorm();
    if (!(length > 1e-9 && length < 1e9)) return Result::invalid("a vector of that length shows no direction");
    z /= length;
    const s2::Frame seen = s2::frame_at(z), x = binnacle::matrix_at<3, 3>(in.x[direction_].data());
    if (s2::direction(x).dot(z) < least_cosine)
      return Result::unsupported("it is seen more than 135 degrees from the estimate");
    out.rows = 2;
    out.residual.segment(0, 2).as<2>() = -s2::minus(s2::direction(x), seen);
    if (auto H = out.H[direction_]) H.block(0, 0, 2, 2).as<2, 2>() = s2::minus_jacobian(x, seen);
    for (int i = 0; i < 2; ++i) out.R(i, i) = variance_;
    return Result::ok();
  }

 private:
  static constexpr double least_cosine = -0.707;  // ⊟ and its derivative lose their meaning towards −1

  binnacle::Port direction_;
  binnacle::Fields<3> seen_;
  double variance_;  // rad²
};
