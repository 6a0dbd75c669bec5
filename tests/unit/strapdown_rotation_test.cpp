// SPDX-License-Identifier: Apache-2.0
// strapdown/rotation.hpp against Eigen's own rotations, series and finite differences.
#include "catch.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "strapdown/rotation.hpp"

namespace strapdown_rotation_test {

using namespace binnacle::strapdown;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

constexpr double pi = std::numbers::pi;

Matrix3d eigen_rotation(const Vector3d& phi) {
  return phi.norm() == 0.0 ? Matrix3d(Matrix3d::Identity())
                           : Eigen::AngleAxisd(phi.norm(), phi.normalized()).toRotationMatrix();
}

std::vector<Vector3d> rotation_vectors() {
  const std::vector<Vector3d> axes = {Vector3d{1, 0, 0}, Vector3d{0, -1, 0}, Vector3d{0, 0, 1},
                                      Vector3d{1, 2, -3}.normalized(), Vector3d{-5, 1, 0.5}.normalized()};
  std::vector<Vector3d> all;
  for (const Vector3d& axis : axes) {
    for (double angle : {0.0, 1e-300, 1e-12, 1e-7, 1e-3, 0.1, 0.4999, 0.5001, 1.0, 2.5, 3.1, pi - 1e-6, pi - 1e-10}) {
      all.push_back(angle * axis);
    }
  }
  return all;
}

}  // namespace

TEST_CASE("the cross product matrix", "[strapdown][rotation]") {
  const Vector3d a{1, -2, 3}, b{0.3, 0.7, -4};
  REQUIRE((skew(a) * b - a.cross(b)).norm() < 1e-15);
  REQUIRE((skew(a) + skew(a).transpose()).norm() == 0.0);
}

TEST_CASE("a quaternion's product, conjugate and matrix agree with Eigen", "[strapdown][rotation]") {
  const Vector4d q = Vector4d{0.3, -0.5, 0.7, 0.2}.normalized(), p = Vector4d{-0.1, 0.9, 0.4, -0.6}.normalized();
  const Eigen::Quaterniond eq(q[0], q[1], q[2], q[3]), ep(p[0], p[1], p[2], p[3]);
  const Eigen::Quaterniond product = eq * ep;
  REQUIRE((quaternion_product(q, p) - Vector4d{product.w(), product.x(), product.y(), product.z()}).norm() < 1e-15);
  REQUIRE((quaternion_product(q, quaternion_conjugate(q)) - Vector4d{1, 0, 0, 0}).norm() < 1e-15);
  REQUIRE((dcm_from_quaternion(q) - eq.toRotationMatrix()).norm() < 1e-15);
  REQUIRE((dcm_from_quaternion(quaternion_product(q, p)) - dcm_from_quaternion(q) * dcm_from_quaternion(p)).norm() <
          3e-15);
  REQUIRE(std::abs(quaternion_normalised(3.7 * q).norm() - 1.0) < 1e-15);
}

TEST_CASE("exp and log of a rotation vector", "[strapdown][rotation]") {
  for (const Vector3d& phi : rotation_vectors()) {
    const Vector4d q = quaternion_exp(phi);
    REQUIRE(std::abs(q.norm() - 1.0) < 4e-16);
    REQUIRE((dcm_from_quaternion(q) - eigen_rotation(phi)).norm() < 3e-15);
    REQUIRE((quaternion_log(q) - phi).norm() <= 1e-15 + 4e-16 * phi.norm());
    REQUIRE((quaternion_log(-q) - phi).norm() <= 1e-15 + 4e-16 * phi.norm());
    // Relative, so that a tiny angle keeps all its digits.
    if (phi.norm() > 0.0 && phi.norm() < 1e-3) {
      REQUIRE((quaternion_log(q) - phi).norm() < 1e-14 * phi.norm());
    }
  }
  // Past half a turn the short way round is returned.
  REQUIRE((quaternion_log(quaternion_exp({0, 0, 3.5})) - Vector3d{0, 0, 3.5 - 2 * pi}).norm() < 1e-14);
  REQUIRE(std::abs(quaternion_log({0, 1, 0, 0}).norm() - pi) < 1e-15);
}

TEST_CASE("a rotation matrix turns into its quaternion, half turns included", "[strapdown][rotation]") {
  for (const Vector3d& phi : rotation_vectors()) {
    const Vector4d q = quaternion_from_dcm(eigen_rotation(phi));
    REQUIRE(q[0] >= 0.0);
    REQUIRE((quaternion_log(quaternion_product(q, quaternion_conjugate(quaternion_exp(phi))))).norm() < 2e-15);
  }
  for (const Vector3d& axis : {Vector3d{1, 0, 0}, Vector3d{0, 1, 0}, Vector3d{0, 0, 1}}) {
    const Vector4d q = quaternion_from_dcm(eigen_rotation(pi * axis));
    REQUIRE((q.tail<3>().cwiseAbs() - axis).norm() < 1e-15);
  }
}

TEST_CASE("roll, pitch and yaw", "[strapdown][rotation]") {
  const Vector4d q = quaternion_from_euler({0.2, -0.4, 1.9});
  const Matrix3d expected = (Eigen::AngleAxisd(1.9, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.4, Vector3d::UnitY()) *
                             Eigen::AngleAxisd(0.2, Vector3d::UnitX()))
                                .toRotationMatrix();
  REQUIRE((dcm_from_quaternion(q) - expected).norm() < 1e-15);
  // A nose-up body points its x axis above the horizon, i.e. towards negative down.
  REQUIRE(dcm_from_quaternion(quaternion_from_euler({0, 0.1, 0}))(2, 0) < 0.0);

  for (double roll : {-3.0, -0.3, 0.0, 0.9, 3.1}) {
    for (double pitch : {-1.57, -0.8, 0.0, 0.3, 1.5}) {
      for (double yaw : {-3.1, -1.0, 0.0, 2.2}) {
        const Vector3d angles{roll, pitch, yaw};
        REQUIRE((euler_from_quaternion(quaternion_from_euler(angles)) - angles).norm() < 1e-12);
      }
    }
  }
  // Straight up only the difference of yaw and roll is left, but the angles still rebuild the attitude.
  for (double pitch : {pi / 2, -pi / 2, pi / 2 - 1e-9, pi / 2 - 1e-7}) {
    const Vector4d up = quaternion_from_euler({0.7, pitch, -0.4});
    REQUIRE(attitude_minus(quaternion_from_euler(euler_from_quaternion(up)), up).norm() < 1e-8);
    REQUIRE((dcm_from_quaternion(quaternion_from_euler(euler_from_quaternion(up))) - dcm_from_quaternion(up)).norm() <
            1e-8);
  }
}

TEST_CASE("the left Jacobian of SO(3)", "[strapdown][rotation]") {
  for (const Vector3d& phi : rotation_vectors()) {
    const Matrix3d jacobian = left_jacobian(phi);
    REQUIRE((jacobian * left_jacobian_inverse(phi) - Matrix3d::Identity()).norm() < 1e-13);
    Matrix3d numeric;
    const double step = 1e-4;
    for (int i = 0; i < 3; ++i) {
      const Vector3d d = step * Vector3d::Unit(i);
      numeric.col(i) =
          (quaternion_log(quaternion_product(quaternion_exp(phi + d), quaternion_conjugate(quaternion_exp(phi)))) -
           quaternion_log(quaternion_product(quaternion_exp(phi - d), quaternion_conjugate(quaternion_exp(phi))))) /
          (2 * step);
    }
    REQUIRE((jacobian - numeric).norm() < 1e-8);
  }
}

TEST_CASE("attitude error: truth = exp(phi) estimate", "[strapdown][rotation]") {
  const Vector4d q = quaternion_from_euler({0.2, -0.4, 1.9});
  const Vector3d phi{1e-6, -2e-6, 3e-6};
  const Vector4d truth = attitude_plus(q, phi);
  const Matrix3d hat = dcm_from_quaternion(q);
  // C_hat = (I − [phi×]) C_true, phi in navigation components.
  REQUIRE((hat - (Matrix3d::Identity() - skew(phi)) * dcm_from_quaternion(truth)).norm() < 3e-11);
  for (const Vector3d& big : rotation_vectors()) {
    REQUIRE((attitude_minus(attitude_plus(q, big), q) - big).norm() < 2e-15);
  }
}

}  // namespace strapdown_rotation_test
