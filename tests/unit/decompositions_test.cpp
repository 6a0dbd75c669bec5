// SPDX-License-Identifier: Apache-2.0
// Decompositions against what defines them.
#include "algebra/decompositions.hpp"

#include <cmath>

#include <Eigen/Dense>

#include "catch.hpp"

namespace decompositions_test {

using namespace binnacle::algebra;

constexpr double rounding = 1e-12;

/// A symmetric positive definite matrix that is not diagonal.
MatrixXd definite() {
  MatrixXd B(4, 4);
  B << 2, -1, 0.5, 0, 1, 3, 0, 0.25, -0.5, 0.75, 1.5, 1, 0, 0.3, -0.2, 0.8;
  return B * B.transpose();
}

MatrixXd right_side() {
  MatrixXd B(4, 2);
  B << 1, -2, 3, 0.5, -1, 4, 2, 1;
  return B;
}

bool are_equal(const MatrixXd& a, const MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff() < rounding; }

TEST_CASE("a Cholesky factor is lower, gives its matrix, and solves") {
  const MatrixXd A = definite(), B = right_side();
  const Cholesky factor(A);
  REQUIRE(factor.is_positive());
  const MatrixXd L = factor.L();
  CHECK(are_equal(L, MatrixXd(L.triangularView<Eigen::Lower>())));
  CHECK(are_equal(L * L.transpose(), A));
  CHECK(are_equal(A * factor.solve(B), B));
  CHECK(are_equal(A * factor.solve_vector(B.col(1)), B.col(1)));
  CHECK(are_equal(L * factor.solve_L(B), B));
  CHECK(are_equal(L * factor.solve_L_vector(B.col(0)), B.col(0)));
  CHECK(are_equal(factor.times_L(B), L * B));
  CHECK(std::abs(factor.log_determinant() - std::log(A.determinant())) < rounding);
  CHECK(factor.rcond() > 0);
}

TEST_CASE(
    "a matrix that is not positive definite has no Cholesky factor, and one that is nearly singular a small rcond") {
  MatrixXd A = definite();
  A(2, 2) = -1;
  CHECK_FALSE(Cholesky(A).is_positive());
  MatrixXd nearly = MatrixXd::Identity(2, 2);
  nearly(1, 1) = 1e-12;
  CHECK(Cholesky(nearly).rcond() < 1e-9);
  CHECK(Cholesky(MatrixXd::Identity(2, 2)).rcond() > 0.1);
}

TEST_CASE("a pivoted factor solves, and its D is negative in an indefinite matrix") {
  const MatrixXd A = definite(), B = right_side();
  const PivotedCholesky factor(A);
  REQUIRE(factor.is_factored());
  CHECK(factor.D().minCoeff() > 0);
  CHECK(are_equal(A * factor.solve(B), B));
  CHECK(are_equal(A * factor.solve_vector(B.col(1)), B.col(1)));
  MatrixXd indefinite = A;
  indefinite(0, 0) = -5;
  CHECK(PivotedCholesky(indefinite).D().minCoeff() < 0);
}

TEST_CASE("a spectrum is ascending, orthonormal, and gives its matrix") {
  const MatrixXd A = definite();
  const Spectrum found = spectrum(A);
  CHECK(are_equal(found.vectors * found.values.asDiagonal() * found.vectors.transpose(), A));
  CHECK(are_equal(found.vectors.transpose() * found.vectors, MatrixXd::Identity(4, 4)));
  for (Eigen::Index i = 1; i < 4; ++i) CHECK(found.values[i] > found.values[i - 1]);
  CHECK(are_equal(eigenvalues(A), found.values));
}

TEST_CASE("a generalized spectrum solves A v = l B v with vectors of unit length in B") {
  const MatrixXd B = definite();
  MatrixXd A = definite() + 2 * MatrixXd::Identity(4, 4);
  A(0, 3) = A(3, 0) = 0.7;
  const Spectrum found = generalized_spectrum(A, B);
  CHECK(are_equal(A * found.vectors, B * found.vectors * found.values.asDiagonal()));
  CHECK(are_equal(found.vectors.transpose() * B * found.vectors, MatrixXd::Identity(4, 4)));
}

TEST_CASE(
    "a left inverse is the inverse of what is square, the weighted mean of more rows, and empty if rows do not "
    "determine it") {
  MatrixXd H(3, 2);
  H << 2, 1, 0, 0, -1, 3;
  const MatrixXd R = Eigen::Vector3d(4, 1, 0.25).asDiagonal();
  const MatrixXd B = left_inverse(H, R);
  REQUIRE(B.rows() == 2);
  CHECK(are_equal(B * H, MatrixXd::Identity(2, 2)));
  CHECK(B.col(1).isZero(0));

  H.row(1) << 1, 1;
  const MatrixXd weights = R.inverse();
  CHECK(are_equal(left_inverse(H, R), (H.transpose() * weights * H).inverse() * H.transpose() * weights));

  H.col(1) = 2 * H.col(0);
  CHECK(left_inverse(H, R).size() == 0);
  CHECK(left_inverse(MatrixXd::Zero(3, 2), R).size() == 0);
  CHECK(are_equal(inverse(definite()) * definite(), MatrixXd::Identity(4, 4)));
}

TEST_CASE("the nearest rotation is one, undoes a rotation with noise, and never reflects") {
  const Matrix3d turned = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  CHECK(are_equal(singular_values(turned).nearest_rotation(), turned));

  Matrix3d reflected = turned;
  reflected.col(2) *= -0.1;
  const SingularValues found = singular_values(reflected);
  CHECK(found.handedness() == -1);
  CHECK(are_equal(found.U * found.s.asDiagonal() * found.V.transpose(), reflected));
  const Matrix3d R = found.nearest_rotation();
  CHECK(are_equal(R.transpose() * R, MatrixXd::Identity(3, 3)));
  CHECK(R.determinant() > 0.99);
  // No small turn of it has a larger trace.
  for (int axis = 0; axis < 3; ++axis)
    for (const double angle : {-1e-3, 1e-3}) {
      const Matrix3d other = R * Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
      CHECK((other.transpose() * reflected).trace() < (R.transpose() * reflected).trace());
    }
}

}  // namespace decompositions_test
