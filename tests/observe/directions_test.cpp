// SPDX-License-Identifier: Apache-2.0
// Directions out of matrices of which they are known.
#include "catch.hpp"

#include <cmath>

#include <Eigen/Dense>

#include "observe/directions.hpp"

namespace directions_test {

using namespace binnacle::observe;
using Eigen::MatrixXd;
using Eigen::Vector4d;
using Eigen::VectorXd;

namespace {

/// D that leaves the span of N alone and removes 0.999 of what is across it.
MatrixXd seeing_all_but(const MatrixXd& N) {
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(N).householderQ() * MatrixXd::Identity(N.rows(), N.cols());
  return 0.999 * (MatrixXd::Identity(N.rows(), N.rows()) - Q * Q.transpose());
}

}  // namespace

TEST_CASE("directions that are not seen come apart into the few components of each") {
  // Two pairs, whose eigenvectors are any mixture of the two.
  MatrixXd N(4, 2);
  N << 1, 1, 0.5, 0.5, 1, -1, -2, 2;
  const MatrixXd W = Vector4d(3, 1, 1e-3, 100).asDiagonal();
  const auto weak = weak_directions(W, seeing_all_but(N));
  REQUIRE(weak.size() == 2);
  REQUIRE(weak[0].parts.size() == 2);
  CHECK(weak[0].parts[0].row == 0);
  CHECK(weak[0].parts[1].row == 1);
  CHECK(weak[0].parts[0].displacement == Approx(3 * 2 / std::sqrt(5)).epsilon(1e-6));
  CHECK(weak[0].parts[1].displacement == Approx(1 / std::sqrt(5)).epsilon(1e-6));
  CHECK(weak[0].parts[0].share == Approx(1 / (1 + 0.001 * 0.25)).epsilon(1e-6));
  CHECK(weak[0].parts[1].of_before == Approx(0.2).epsilon(1e-6));
  REQUIRE(weak[1].parts.size() == 2);
  CHECK(weak[1].parts[0].row == 2);
  CHECK(weak[1].parts[0].displacement == Approx(1e-3 / std::sqrt(5)).epsilon(1e-6));
  CHECK(weak[1].parts[1].displacement == Approx(-100 * 2 / std::sqrt(5)).epsilon(1e-6));  // of opposite sign
}

TEST_CASE("where all is seen there is no weak direction, and half of the variance is the limit") {
  const MatrixXd W = MatrixXd::Identity(2, 2);
  CHECK(weak_directions(W, Eigen::Vector2d(0.5, 0.9).asDiagonal()).empty());
  const auto weak = weak_directions(W, Eigen::Vector2d(0.499, 0.9).asDiagonal());
  REQUIRE(weak.size() == 1);
  CHECK(weak[0].parts[0].row == 0);
  CHECK(weak[0].parts[0].displacement == Approx(std::sqrt(1 - 0.499)));
}

TEST_CASE("singular values are those of the whitened information") {
  MatrixXd D = MatrixXd::Zero(3, 3);
  D.diagonal() << 0.5, 0, 100.0 / 101;  // information 1, 0, 100
  const auto values = singular_values(D);
  REQUIRE(values.size() == 3);
  CHECK(values[0] == Approx(10));
  CHECK(values[1] == Approx(1));
  CHECK(values[2] == 0);
  CHECK(variances_left(2 * MatrixXd::Identity(3, 3), D).isApprox(4 * Eigen::Vector3d(0.5, 1, 1.0 / 101), 1e-12));
}

TEST_CASE("what a filter removes along a direction that is not seen is found, and nothing where it removes nothing") {
  VectorXd n(4);
  n << 1, 0, -1, 0;
  const MatrixXd W = Vector4d(2, 1, 5, 1).asDiagonal();
  const MatrixXd seen = seeing_all_but(n);
  CHECK(spurious_directions(W, seen, seen).empty());
  const VectorXd u = n.normalized();
  CHECK(spurious_directions(W, seen + 0.49 * u * u.transpose(), seen).empty());
  const auto found = spurious_directions(W, seen + 0.9 * u * u.transpose(), seen);
  REQUIRE(found.size() == 1);
  CHECK(found[0].claimed == Approx(0.9));
  CHECK(found[0].removed == Approx(0).margin(1e-12));
  REQUIRE(found[0].parts.size() == 2);
  CHECK(found[0].parts[0].row == 0);
  CHECK(found[0].parts[0].displacement == Approx(2 / std::sqrt(2)));
  CHECK(found[0].parts[1].row == 2);
  CHECK(found[0].parts[1].displacement == Approx(-5 / std::sqrt(2)));
}

TEST_CASE("a filter that sees another direction instead is not spared by the one that it does not see") {
  // On the path the first component is not seen; the filter thinks that it is, and that the second is not.
  const MatrixXd W = MatrixXd::Identity(2, 2);
  const auto found =
      spurious_directions(W, Eigen::Vector2d(0.99, 0).asDiagonal(), Eigen::Vector2d(0, 0.99).asDiagonal());
  REQUIRE(found.size() == 1);
  CHECK(found[0].parts[0].row == 0);
  CHECK(found[0].claimed == Approx(0.99));
}

}  // namespace directions_test
