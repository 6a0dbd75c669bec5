// SPDX-License-Identifier: Apache-2.0
// The heading of a vehicle on the ground.
#include "heading_block.hpp"

#include <cmath>
#include <numbers>

namespace binnacle::odometry {

namespace {

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

ComponentSpec HeadingBlock::spec() {
  ComponentSpec spec;
  spec.type = "heading";
  spec.summary = "Heading of a vehicle on the ground: an angle about down, from true north, east positive.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 2.2";
  spec.kind = "heading";
  spec.example = R"json({"init": {"yaw": "90 deg"}, "sigma": "20 deg"})json";
  return spec;
}

HeadingBlock::HeadingBlock(const Binding& /*binding*/) {
  declaration_.kind = "heading";
  declaration_.stored_size = 1;
  declaration_.error = {{"yaw", "rad"}};
  declaration_.outputs = {
      output("yaw", "rad").shown_in("deg").angle().about("about down, from true north, east positive")};
  declaration_.error_display_unit = "deg";
}

void HeadingBlock::plus(ConstVectorView x, ConstVectorView delta, VectorView result) const {
  result[0] = wrapped(x[0] + delta[0]);
}

void HeadingBlock::minus(ConstVectorView y, ConstVectorView x, VectorView delta) const {
  delta[0] = wrapped(y[0] - x[0]);
}

void HeadingBlock::read(ConstVectorView x, VectorView outputs) const { outputs[0] = x[0]; }

Result HeadingBlock::write(ConstVectorView outputs, VectorView x) const {
  if (!std::isfinite(outputs[0])) return Result::invalid("the yaw is not finite");
  if (std::abs(outputs[0]) > 2 * std::numbers::pi) return Result::invalid("the yaw is more than one turn");
  x[0] = wrapped(outputs[0]);
  return Result::ok();
}

bool HeadingBlock::output_jacobian(ConstVectorView /*x*/, MatrixView J) const {
  J(0, 0) = 1;
  return true;
}

}  // namespace binnacle::odometry
