// SPDX-License-Identifier: Apache-2.0
// frames: a rotation as a matrix, a quaternion or turns in any order, and what is refused.
#include "frames/mounting.hpp"

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "binnacle/bind.hpp"
#include "catch.hpp"
#include "json_members.hpp"

namespace mounting_test {

using namespace binnacle;
using namespace binnacle::json_members;
using binnacle::test::Contains;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Json vector(const std::vector<double>& numbers) { return numbers; }

Json matrix(const Matrix3d& M) {
  Json rows = Json::array();
  for (const auto& row : M.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

Matrix3d rotation(const Members& given) {
  ComponentSpec spec;
  spec.type = "mounted";
  spec.parameters = frames::mounting_parameters();
  const ParameterValue value = testing::read_parameters(spec, {object(given)});
  return frames::mounting_rotation(Parameters(value));
}

std::string said(const Members& given) {
  try {
    rotation(given);
  } catch (const ComponentError& error) {
    return error.pointer() + ": " + error.what();
  }
  return "nothing";
}

const Matrix3d nominal =
    (AngleAxisd(0.3, Vector3d::UnitZ()) * AngleAxisd(-0.2, Vector3d::UnitY()) * AngleAxisd(1.1, Vector3d::UnitX()))
        .toRotationMatrix();

}  // namespace

TEST_CASE("a mounting by angles, turns, quaternion and matrix is the same", "[frames]") {
  const Eigen::Quaterniond q(nominal);
  CHECK(rotation({{"roll", 1.1}, {"pitch", -0.2}, {"yaw", 0.3}}).isApprox(nominal, 1e-14));
  CHECK(
      rotation({{"euler", object({{"order", "zyx"}, {"angles", vector({0.3, -0.2, 1.1})}})}}).isApprox(nominal, 1e-14));
  CHECK(rotation({{"quaternion", object({{"order", "wxyz"}, {"values", vector({q.w(), q.x(), q.y(), q.z()})}})}})
            .isApprox(nominal, 1e-14));
  CHECK(rotation({{"quaternion", object({{"order", "xyzw"}, {"values", vector({q.x(), q.y(), q.z(), q.w()})}})}})
            .isApprox(nominal, 1e-14));
  CHECK(rotation({{"matrix", matrix(nominal)}}).isApprox(nominal, 1e-14));
  CHECK(rotation({{"matrix", matrix(nominal)}, {"inverse", true}}).isApprox(nominal.transpose(), 1e-14));
  const Matrix3d flipped = Vector3d(1, -1, -1).asDiagonal() * nominal;
  CHECK(rotation({{"matrix", matrix(nominal)}, {"flip", "flu_to_frd"}}).isApprox(flipped, 1e-14));
  CHECK(rotation({{"matrix", matrix(nominal)}, {"flip", "flu_to_frd"}, {"inverse", true}})
            .isApprox(flipped.transpose(), 1e-14));
}

TEST_CASE("turns are multiplied in the order that is written", "[frames]") {
  // A quarter turn about z, then what comes after it in the product: x' = z.
  const double quarter = M_PI / 2;
  const Matrix3d zxy = rotation({{"euler", object({{"order", "zxy"}, {"angles", vector({quarter, 0.4, -0.7})}})}});
  CHECK(zxy.isApprox((AngleAxisd(quarter, Vector3d::UnitZ()) * AngleAxisd(0.4, Vector3d::UnitX()) *
                      AngleAxisd(-0.7, Vector3d::UnitY()))
                         .toRotationMatrix(),
                     1e-14));
  const Matrix3d xz = rotation({{"euler", object({{"order", "xzx"}, {"angles", vector({quarter, quarter, 0})}})}});
  CHECK((xz * Vector3d::UnitX() - Vector3d::UnitZ()).norm() < 1e-14);  // Rz: x to y; Rx: y to z
}

TEST_CASE("a matrix of axes exchanged is exact, a printed one is made orthonormal", "[frames]") {
  Matrix3d exchanged;
  exchanged << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  CHECK(rotation({{"matrix", matrix(exchanged)}}) == exchanged);
  Matrix3d printed;
  printed << 0.707, -0.707, 0, 0.707, 0.707, 0, 0, 0, 1;
  const Matrix3d made = rotation({{"matrix", matrix(printed)}});
  CHECK((made * made.transpose()).isApprox(Matrix3d::Identity(), 1e-14));
  CHECK((made - printed).norm() < 1e-3);
}

TEST_CASE("what is no rotation is refused with what was found", "[frames]") {
  Matrix3d reflection = Matrix3d::Identity(), long_row = Matrix3d::Identity(), oblique = Matrix3d::Identity();
  reflection(2, 2) = -1;
  long_row(1, 1) = 1.2;
  oblique.row(2) << 0.6, 0, 0.8;
  CHECK(said({{"matrix", matrix(reflection)}}) ==
        "/matrix: the determinant of a rotation is 1; found -1: a reflection. Is the sign of an axis wrong, or are two "
        "axes "
        "exchanged?");
  CHECK(said({{"matrix", matrix(long_row)}}) == "/matrix: row 2 of a rotation has the length 1; found 1.2");
  CHECK(said({{"matrix", matrix(oblique)}}) ==
        "/matrix: rows of a rotation are orthogonal; the product of row 3 and row 1 is 0.6");
  CHECK(said({{"quaternion", object({{"order", "wxyz"}, {"values", vector({1, 1, 0, 0})}})}}) ==
        "/quaternion/values: the norm of a unit quaternion is 1; found 1.414");
  CHECK_THAT(said({{"matrix", matrix(nominal)}, {"yaw", 0.1}}),
             Contains("/matrix: the rotation is given twice, by roll, pitch, yaw too"));
  CHECK_THAT(said({{"matrix", matrix(nominal)}, {"euler", object({{"order", "zyx"}, {"angles", vector({0, 0, 0})}})}}),
             Contains("/matrix: the rotation is given twice, by 'euler' too"));
}

}  // namespace mounting_test
