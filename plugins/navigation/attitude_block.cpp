// SPDX-License-Identifier: Apache-2.0
// An attitude with its error as tilt in navigation axes.
#include "attitude_block.hpp"

#include <cmath>
#include <numbers>

#include "binnacle/view.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::navigation {

ComponentSpec AttitudeBlock::spec() {
  ComponentSpec spec;
  spec.type = "attitude";
  spec.former_names = {"phi_error/attitude"};
  spec.summary = "Attitude of the body in north-east-down axes; its error as a rotation vector in those axes.";
  spec.source = "papers 001 (3) and 003 (3)";
  spec.kind = "attitude";
  spec.parameters = {parameter::vector("mounting", "rad", 3)
                         .defaults("0")
                         .at_least(-2.0 * std::numbers::pi)
                         .at_most(2.0 * std::numbers::pi)
                         .about("roll, pitch and yaw of the body in the axes of the values that are read and written"),
                     parameter::boolean("reset").defaults("true").about(
                         "whether a correction turns P by the reset Jacobian; false where the heading is known far "
                         "worse than the tilt, as during a long rest")};
  spec.example = R"json({"init": {"roll": "0.2 deg", "pitch": 0, "yaw": "90 deg"},
    "sigma": ["0.5 deg", "0.5 deg", "5 deg"]})json";
  return spec;
}

AttitudeBlock::AttitudeBlock(const Binding& binding)
    : q_rb_(strapdown::quaternion_from_euler(binding.parameters().vector("mounting"))),
      is_reset_(binding.parameters().boolean("reset")) {
  declaration_.kind = "attitude";
  declaration_.stored_size = 4;
  declaration_.error = {{"north", "rad"}, {"east", "rad"}, {"down", "rad"}};
  declaration_.outputs = {{"roll", "rad", "deg", true, true, "about body x, turned last from navigation axes"},
                          {"pitch", "rad", "deg", true, true, "about y, nose up positive, within 90 deg"},
                          {"yaw", "rad", "deg", true, true, "about down, from true north, east positive"}};
  declaration_.norms = {{"tilt", {0, 1}}};
  declaration_.error_display_unit = "deg";
}

void AttitudeBlock::plus(ConstVectorView x, ConstVectorView delta, VectorView result) const {
  result.as<4>() = strapdown::attitude_plus(x.as<4>(), delta.as<3>());
}

void AttitudeBlock::minus(ConstVectorView y, ConstVectorView x, VectorView delta) const {
  delta.as<3>() = strapdown::attitude_minus(y.as<4>(), x.as<4>());
}

Eigen::Vector4d AttitudeBlock::as_read(ConstVectorView x) const {
  return strapdown::quaternion_product(x.as<4>(), strapdown::quaternion_conjugate(q_rb_));
}

void AttitudeBlock::read(ConstVectorView x, VectorView outputs) const {
  outputs.as<3>() = strapdown::euler_from_quaternion(as_read(x));
}

Result AttitudeBlock::write(ConstVectorView outputs, VectorView x) const {
  const auto angles = outputs.as<3>();
  if (!angles.allFinite()) return Result::invalid("roll, pitch or yaw is not finite");
  if (std::abs(angles[1]) > std::numbers::pi / 2) return Result::invalid("the pitch lies beyond the vertical");
  if (angles.cwiseAbs().maxCoeff() > 2.0 * std::numbers::pi)
    return Result::invalid("roll or yaw is more than one turn");
  x.as<4>() = strapdown::quaternion_product(strapdown::quaternion_from_euler(angles), q_rb_);
  return Result::ok();
}

bool AttitudeBlock::reset_jacobian(ConstVectorView /*x*/, ConstVectorView delta, MatrixView G) const {
  if (is_reset_) G.as<3, 3>() = strapdown::left_jacobian(delta.as<3>());
  return is_reset_;
}

bool AttitudeBlock::output_jacobian(ConstVectorView x, MatrixView J) const {
  return strapdown::euler_jacobian(as_read(x), J.as<3, 3>());
}

}  // namespace binnacle::navigation
