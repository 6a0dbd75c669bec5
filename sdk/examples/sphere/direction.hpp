// SPDX-License-Identifier: Apache-2.0
// A direction as a state block.
#pragma once

#include <binnacle/plugin.hpp>

#include <cmath>

#include "s2.hpp"

/// Kind "direction": a unit vector and two axes normal to it, that go along with it; two degrees of freedom [rad].
class Direction final : public binnacle::StateBlock {
 public:
  static binnacle::ComponentSpec spec() {
    binnacle::ComponentSpec spec;
    spec.type = "direction";
    spec.summary = "A direction: a point of the unit sphere, its error in the plane that touches it.";
    spec.source = "Hertzberg, Wagner, Frese, Schroeder, Integrating generic sensor fusion algorithms, 2013, section 3";
    spec.kind = "direction";
    spec.example = R"json({"init": {"x": 0, "y": 0.6, "z": 0.8}, "sigma": "5 deg"})json";
    return spec;
  }

  explicit Direction(const binnacle::Binding&) {
    using binnacle::output;
    declaration_.kind = "direction";
    declaration_.stored_size = 9;
    declaration_.error = {{"first", "rad"}, {"second", "rad"}};
    for (const char* axis : {"x", "y", "z"})
      declaration_.outputs.push_back(output(axis, "1").unscored().about("component of the unit vector"));
    declaration_.norms = {{"angle", {0, 1}}};
    declaration_.error_display_unit = "deg";
  }

  const binnacle::StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(binnacle::ConstVectorView x, binnacle::ConstVectorView delta, binnacle::VectorView result) const override {
    frame_of(result) = s2::plus(frame_of(x), delta.as<2>());
  }
  void minus(binnacle::ConstVectorView y, binnacle::ConstVectorView x, binnacle::VectorView delta) const override {
    delta.as<2>() = s2::minus(s2::direction(frame_of(y)), frame_of(x));
  }
  void read(binnacle::ConstVectorView x, binnacle::VectorView outputs) const override {
    outputs.as<3>() = s2::direction(frame_of(x));
  }
  binnacle::Result write(binnacle::ConstVectorView outputs, binnacle::VectorView x) const override {
    const s2::Vector3 v = outputs.as<3>();
    const double length = v.norm();
    if (!(std::abs(length - 1) < 0.01)) return binnacle::Result::invalid("x, y, z are a vector of length 1");
    frame_of(x) = s2::frame_at(v / length);
    return binnacle::Result::ok();
  }
  bool reset_jacobian(binnacle::ConstVectorView /*x*/, binnacle::ConstVectorView delta,
                      binnacle::MatrixView G) const override {
    G.as<2, 2>() = s2::reset_jacobian(delta.as<2>());
    return true;
  }

 private:
  static binnacle::ConstMapOf<3, 3> frame_of(binnacle::ConstVectorView x) {
    return binnacle::matrix_at<3, 3>(x.data());
  }
  static binnacle::MapOf<3, 3> frame_of(binnacle::VectorView x) { return binnacle::matrix_at<3, 3>(x.data()); }

  binnacle::StateBlockDeclaration declaration_;
};
