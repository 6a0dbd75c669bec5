// SPDX-License-Identifier: Apache-2.0
// binnacle/jacobian.hpp against Jacobians by hand.
#include "catch.hpp"

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "binnacle/jacobian.hpp"

namespace jacobian_test {

using namespace binnacle;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

const Vector2d beacon(0, 100);
const Vector2d x(30, -20);

const auto range = [](const auto& delta) { return jacobian::column((x + delta - beacon).norm()); };

/// A turned vector, C(δ) v with C = I + [δ×] + ½[δ×]²: to second order the exponential.
const Vector3d v(1, -2, 3);
const auto turned = [](const auto& delta) {
  using Scalar = typename std::decay_t<decltype(delta)>::Scalar;
  const Eigen::Matrix<Scalar, 3, 1> w = v.cast<Scalar>();
  const Eigen::Matrix<Scalar, 3, 1> once = delta.cross(w);
  const Eigen::Matrix<Scalar, 3, 1> twice = delta.cross(once);
  const Eigen::Matrix<Scalar, 3, 1> result = w + once + Scalar(0.5) * twice;
  return result;
};

Eigen::Matrix3d minus_v_cross() {
  Eigen::Matrix3d m;
  m << 0, v[2], -v[1], -v[2], 0, v[0], v[1], -v[0], 0;
  return m;
}

}  // namespace

TEST_CASE("jacobian: dual numbers give the Jacobian by hand to roundoff") {
  const Vector2d d = x - beacon;
  const Eigen::RowVector2d by_hand = d.transpose() / d.norm();
  REQUIRE((jacobian::by_duals<1, 2>(range) - by_hand).norm() < 1e-15);
  REQUIRE(range(Vector2d::Zero().eval())[0] == d.norm());
  // ∂(δ × v)/∂δ = −[v×]: the sign is what this test is for.
  REQUIRE((jacobian::by_duals<3, 3>(turned) - minus_v_cross()).norm() < 1e-15);
}

TEST_CASE("jacobian: differences give it to the fourth power of the step") {
  const Vector2d d = x - beacon;
  const Eigen::RowVector2d by_hand = d.transpose() / d.norm();
  const auto error = [&](double step) {
    return (jacobian::by_differences<1, 2>(range, Vector2d(step, step)) - by_hand).norm();
  };
  REQUIRE(error(1.0) < 1e-10);
  REQUIRE(error(40.0) > 1e-7);  // else the next line shows nothing
  REQUIRE(error(20.0) < error(40.0) / 12);
  REQUIRE((jacobian::by_differences<3, 3>(turned, Vector3d(0.1, 0.1, 0.1)) - minus_v_cross()).norm() < 1e-13);
}

}  // namespace jacobian_test
