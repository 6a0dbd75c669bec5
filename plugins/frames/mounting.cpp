// SPDX-License-Identifier: Apache-2.0
// A fixed rotation between two sets of axes on one body.
#include "mounting.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "algebra/decompositions.hpp"
#include "binnacle/eigen.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::frames {

namespace {

/// Digits that a printed matrix or quaternion may lack.
constexpr double rounding = 1e-3;

ParameterSpec angle(std::string name, std::string text) {
  constexpr double turn = 2.0 * std::numbers::pi;
  return parameter::number(std::move(name), "rad").defaults("0").at_least(-turn).at_most(turn).about(std::move(text));
}

ParameterSpec euler_spec() {
  constexpr double turn = 2.0 * std::numbers::pi;
  return parameter::object("euler",
                           {parameter::choice("order", {"zyx", "xyz", "zxy", "yxz", "xzy", "yzx", "zxz", "zyz", "xyx",
                                                        "xzx", "yxy", "yzy"})
                                .required()
                                .about("order of the product of the rotations as it is written: zyx is Rz Ry Rx"),
                            parameter::vector("angles", "rad", 3)
                                .at_least(-turn)
                                .at_most(turn)
                                .required()
                                .about("angles in this order")})
      .about("three rotations in any order, instead of roll, pitch, yaw");
}

ParameterSpec quaternion_spec() {
  return parameter::object(
             "quaternion",
             {parameter::choice("order", {"wxyz", "xyzw"}).required().about("position of the scalar part"),
              parameter::vector("values", "1", 4).required().about("a unit quaternion")})
      .about("quaternion with v_new = q (0, v) q*, instead of roll, pitch, yaw");
}

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

Eigen::Matrix3d read_matrix(const Eigen::Matrix3d& M) {
  const Eigen::Matrix3d excess = M * M.transpose() - Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    const std::string row = "row " + std::to_string(i + 1);
    if (std::abs(excess(i, i)) > 2 * rounding)
      throw ComponentError(row + " of a rotation has the length 1; found " + text_of(M.row(i).norm()), "/matrix");
    for (int j = 0; j < i; ++j)
      if (std::abs(excess(i, j)) > 2 * rounding)
        throw ComponentError("rows of a rotation are orthogonal; the product of " + row + " and row " +
                                 std::to_string(j + 1) + " is " + text_of(excess(i, j)),
                             "/matrix");
  }
  if (M.determinant() < 0)
    throw ComponentError("the determinant of a rotation is 1; found " + text_of(M.determinant()) +
                             ": a reflection. Is the sign of an axis wrong, or are two axes exchanged?",
                         "/matrix");
  if (excess.isZero(0)) return M;  // axes exchanged: exact
  return algebra::singular_values(M).nearest_rotation();
}

Eigen::Matrix3d read_quaternion(const Parameters& given) {
  Eigen::Vector4d q = given.vector("values");
  if (given.text("order") == "xyzw") q = Eigen::Vector4d(q[3], q[0], q[1], q[2]);
  const double norm = q.norm();
  if (!(std::abs(norm - 1) <= rounding))
    throw ComponentError("the norm of a unit quaternion is 1; found " + text_of(norm), "/quaternion/values");
  return strapdown::dcm_from_quaternion(strapdown::quaternion_normalised(q));
}

Eigen::Matrix3d read_euler(const Parameters& given) {
  const Eigen::Vector3d angles = given.vector("angles");
  Eigen::Matrix3d C = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    const int axis = given.text("order")[static_cast<std::size_t>(i)] - 'x';
    C = C * Eigen::AngleAxisd(angles[i], Eigen::Vector3d::Unit(axis)).toRotationMatrix();
  }
  return C;
}

/// D R, before it may be inverted.
Eigen::Matrix3d read_rotation(const Parameters& parameters) {
  bool has_angles = false;
  for (const char* name : {"roll", "pitch", "yaw"}) has_angles |= parameters.number(name) != 0;
  std::string taken = has_angles ? "roll, pitch, yaw" : "";
  for (const char* name : {"euler", "quaternion", "matrix"}) {
    if (!parameters.has(name)) continue;
    if (!taken.empty())
      throw ComponentError("the rotation is given twice, by " + taken + " too", "/" + std::string(name));
    taken = "'" + std::string(name) + "'";
  }
  if (parameters.has("euler")) return read_euler(parameters.object("euler"));
  if (parameters.has("quaternion")) return read_quaternion(parameters.object("quaternion"));
  if (parameters.has("matrix")) return read_matrix(parameters.matrix("matrix"));
  // Attitude angles are those of Rz Ry Rx as a map from body to navigation, the same product as here.
  return strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(
      {parameters.number("roll"), parameters.number("pitch"), parameters.number("yaw")}));
}

}  // namespace

std::vector<ParameterSpec> mounting_parameters() {
  return {angle("roll", "rotation about x, applied first"),
          angle("pitch", "rotation about y, applied second"),
          angle("yaw", "rotation about z, applied third"),
          euler_spec(),
          quaternion_spec(),
          parameter::matrix("matrix", "1", 3, 3)
              .about("rotation matrix, instead of roll, pitch, yaw; rows: the new x, y, z in the old axes; orthonormal "
                     "to 0.001, determinant 1"),
          parameter::choice("flip", {"none", "flu_to_frd"})
              .defaults("\"none\"")
              .about("flu_to_frd: the rotation results in forward-left-up axes, so y and z are then reversed"),
          parameter::boolean("inverse").defaults("false").about(
              "true: the given rotation is from the new axes to the old axes, so its transpose is used")};
}

Eigen::Matrix3d mounting_rotation(const Parameters& parameters) {
  Eigen::Matrix3d C = read_rotation(parameters);
  if (parameters.text("flip") == "flu_to_frd") C.bottomRows<2>() *= -1.0;
  if (parameters.boolean("inverse")) C.transposeInPlace();
  return C;
}

}  // namespace binnacle::frames
