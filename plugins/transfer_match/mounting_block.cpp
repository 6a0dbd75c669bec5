// SPDX-License-Identifier: Apache-2.0
// How one inertial system is mounted with respect to another.
#include "mounting_block.hpp"

#include <numbers>

#include <Eigen/LU>

#include "binnacle/view.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::transfer_match {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector4d;

constexpr double orthogonality = 1e-6;  // of a matrix typed with seven digits

Vector4d nominal_rotation(const Parameters& parameters) {
  if (!parameters.has("nominal")) return strapdown::quaternion_from_euler(parameters.vector("angles"));
  if (!parameters.vector("angles").isZero(0.0))
    throw ComponentError("the nominal mounting is given twice: as 'nominal' and as 'angles'", "/nominal");
  const Matrix3d C = parameters.matrix("nominal");
  if (!(C * C.transpose()).isIdentity(orthogonality) || !(C.determinant() > 0.0))
    throw ComponentError("'nominal' is not a rotation: its rows must be of unit length, at right angles, right-handed",
                         "/nominal");
  return strapdown::quaternion_normalised(strapdown::quaternion_from_dcm(C));
}

}  // namespace

ComponentSpec MountingBlock::spec() {
  ComponentSpec spec;
  spec.type = "mounting";
  spec.summary = "Mounting of a slave inertial system with respect to its master; its error as a small rotation.";
  spec.source = "paper 000, equations (3) and (5)";
  spec.kind = "mounting";
  spec.parameters = {
      parameter::matrix("nominal", "1", 3, 3)
          .about("nominal C_S^M by rows, slave to master axes; alternative: 'angles'"),
      parameter::vector("angles", "rad", 3)
          .defaults("0")
          .at_least(-2.0 * std::numbers::pi)
          .at_most(2.0 * std::numbers::pi)
          .about("nominal roll, pitch and yaw of the slave in the master's axes; alternative to 'nominal'")};
  spec.example = R"json({"nominal": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], "init": {"mx": 0, "my": 0, "mz": 0},
    "sigma": "1 deg"})json";
  return spec;
}

MountingBlock::MountingBlock(const Binding& binding) : nominal_(nominal_rotation(binding.parameters())) {
  declaration_.kind = "mounting";
  declaration_.stored_size = 4;
  declaration_.error = {{"x", "rad"}, {"y", "rad"}, {"z", "rad"}};
  declaration_.outputs = {{"mx", "rad", "mil", false, false, "about the master's x, from the nominal mounting"},
                          {"my", "rad", "mil", false, false, "about the master's y, from the nominal mounting"},
                          {"mz", "rad", "mil", false, false, "about the master's z, from the nominal mounting"}};
  declaration_.error_display_unit = "mil";
}

void MountingBlock::plus(ConstVectorView x, ConstVectorView delta, VectorView result) const {
  result.as<4>() = strapdown::attitude_plus(x.as<4>(), delta.as<3>());
}

void MountingBlock::minus(ConstVectorView y, ConstVectorView x, VectorView delta) const {
  delta.as<3>() = strapdown::attitude_minus(y.as<4>(), x.as<4>());
}

void MountingBlock::read(ConstVectorView x, VectorView outputs) const {
  outputs.as<3>() = strapdown::attitude_minus(x.as<4>(), nominal_);
}

Result MountingBlock::write(ConstVectorView outputs, VectorView x) const {
  const auto m = outputs.as<3>();
  if (!m.allFinite()) return Result::invalid("a mounting angle is not finite");
  if (m.norm() > std::numbers::pi) return Result::invalid("the mounting is more than half a turn from nominal");
  x.as<4>() = strapdown::attitude_plus(nominal_, m);
  return Result::ok();
}

bool MountingBlock::reset_jacobian(ConstVectorView /*x*/, ConstVectorView delta, MatrixView G) const {
  G.as<3, 3>() = strapdown::left_jacobian(delta.as<3>());
  return true;
}

bool MountingBlock::output_jacobian(ConstVectorView x, MatrixView J) const {
  // m = log(q ⊗ q₀*), and log(exp(φ) exp(m)) = m + J_l⁻¹(m) φ.
  const Eigen::Vector3d m = strapdown::attitude_minus(x.as<4>(), nominal_);
  if (m.norm() > std::numbers::pi - 1e-3) return false;  // the rotation vector jumps to the other side
  J.as<3, 3>() = strapdown::left_jacobian_inverse(m);
  return true;
}

}  // namespace binnacle::transfer_match
