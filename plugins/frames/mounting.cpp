// SPDX-License-Identifier: Apache-2.0
// A fixed rotation between two sets of axes on one body.
#include "mounting.hpp"

#include <numbers>

#include "strapdown/rotation.hpp"

namespace binnacle::frames {

namespace {

ParameterSpec angle(std::string name, std::string text) {
  constexpr double turn = 2.0 * std::numbers::pi;
  return parameter::number(std::move(name), "rad").defaults("0").at_least(-turn).at_most(turn).about(std::move(text));
}

}  // namespace

std::vector<ParameterSpec> mounting_parameters() {
  return {angle("roll", "turn about x, made first"), angle("pitch", "turn about y, made second"),
          angle("yaw", "turn about z, made third"),
          parameter::choice("flip", {"none", "flu_to_frd"})
              .defaults("\"none\"")
              .about("flu_to_frd: the angles lead to forward-left-up axes; y and z are then reversed")};
}

Eigen::Matrix3d mounting_rotation(const Parameters& parameters) {
  // Attitude angles are those of Rz Ry Rx as a map from body to navigation, the same product as here.
  const Eigen::Vector4d q = strapdown::quaternion_from_euler(
      {parameters.number("roll"), parameters.number("pitch"), parameters.number("yaw")});
  Eigen::Matrix3d C = strapdown::dcm_from_quaternion(q);
  if (parameters.text("flip") == "flu_to_frd") C.bottomRows<2>() *= -1.0;
  return C;
}

}  // namespace binnacle::frames
