// SPDX-License-Identifier: Apache-2.0
// Sigma points against their definition and against moments of a Gaussian that are known in closed form.
#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Dense>

#include "catch.hpp"
#include "filter/sigma_points.hpp"

namespace sigma_points_test {

using namespace binnacle;
using namespace binnacle::internal::filter;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd random_matrix(int rows, int columns, std::mt19937& engine) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(engine); });
}

ConstMatrixView view(const MatrixXd& A) {
  return {A.data(), static_cast<int>(A.rows()), static_cast<int>(A.cols()), static_cast<int>(A.rows())};
}
MatrixView view(MatrixXd& A) {
  return {A.data(), static_cast<int>(A.rows()), static_cast<int>(A.cols()), static_cast<int>(A.rows())};
}

/// The points as columns.
MatrixXd points_of(const SigmaPoints& points, int n) {
  MatrixXd all(n, points.count());
  for (int i = 0; i < points.count(); ++i) points.offset(i, {all.col(i).data(), n});
  return all;
}

VectorXd weights_of(const SigmaPoints& points) {
  return VectorXd::NullaryExpr(points.count(), [&](Eigen::Index i) { return points.weight(static_cast<int>(i)); });
}

struct Result {
  Result(SigmaPoints& points, const MatrixXd& e, int n, ConstMatrixView fallback = {})
      : mean(VectorXd::Constant(e.rows(), NAN)),
        M(MatrixXd::Constant(e.rows(), n, NAN)),
        Omega(MatrixXd::Constant(e.rows(), e.rows(), NAN)) {
    points.regress(view(e), fallback, {mean, view(M), view(Omega)});
  }
  VectorXd mean;
  MatrixXd M, Omega;
};

/// Of random rank, with rows that are zero and rows that depend on others.
MatrixXd singular_covariance(int n, std::mt19937& engine) {
  MatrixXd A = random_matrix(n, 1 + static_cast<int>(engine() % static_cast<unsigned>(n)), engine);
  for (int i = 0; i < n; ++i) {
    const auto kind = engine() % 4;
    if (kind == 0) A.row(i).setZero();
    if (kind == 1 && i > 0) A.row(i) = -2 * A.row(i - 1);
  }
  return A * A.transpose();
}

}  // namespace

TEST_CASE("sigma points have the mean and the covariance that they are made of, and no negative weight") {
  std::mt19937 engine(1);
  for (int n = 1; n <= 9; ++n) {
    SigmaPoints points(9, 1);
    for (int trial = 0; trial < 20; ++trial) {
      const MatrixXd A = random_matrix(n, n, engine);
      const MatrixXd P = trial % 2 == 0 ? MatrixXd(A * A.transpose()) : singular_covariance(n, engine);
      points.factor(view(P));
      const MatrixXd xi = points_of(points, n);
      const VectorXd w = weights_of(points);
      INFO("n = " << n << ", rank " << points.rank());
      CHECK((w.array() >= 0).all());
      CHECK(w.sum() == Approx(1));
      CHECK((xi * w).norm() < 1e-12 * (1 + P.norm()));
      CHECK((xi * w.asDiagonal() * xi.transpose() - P).norm() < 1e-13 * (1 + P.norm()));
      CHECK(points.rank() == (trial % 2 == 0 ? n : Eigen::FullPivLU<MatrixXd>(P).setThreshold(1e-12).rank()));
      CHECK(points.least_pivot() > -1e-13);
    }
  }
}

TEST_CASE("up to three directions the fourth moment is a Gaussian's, beyond that the centre has no weight") {
  SigmaPoints points(5, 1);
  const MatrixXd I = MatrixXd::Identity(5, 5);
  for (int n = 1; n <= 5; ++n) {
    points.factor(view(MatrixXd(I.topLeftCorner(n, n))));
    const MatrixXd xi = points_of(points, n);
    const double fourth = xi.row(0).array().pow(4).matrix().dot(weights_of(points));
    CHECK(fourth == Approx(n <= 3 ? 3 : n));
    CHECK(points.weight(0) == Approx(n <= 3 ? 1 - n / 3.0 : 0));
  }
}

TEST_CASE("the regression of a linear function is its matrix, and leaves nothing") {
  std::mt19937 engine(2);
  for (int n = 1; n <= 8; ++n) {
    SigmaPoints points(n, 5);
    const MatrixXd B = random_matrix(n, n, engine), A = random_matrix(5, n, engine);
    const VectorXd b = random_matrix(5, 1, engine);
    points.factor(view(MatrixXd(B * B.transpose())));
    const Result result(points, (A * points_of(points, n)).colwise() + b, n);
    CHECK((result.mean - b).norm() < 1e-12);
    CHECK((result.M - A).norm() < 1e-8);
    CHECK(result.Omega.norm() < 1e-12);
  }
}

TEST_CASE("along directions without points the regression is the fallback, and explains the same covariance") {
  std::mt19937 engine(3);
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 2 + trial % 6;
    const MatrixXd P = singular_covariance(n, engine), A = random_matrix(4, n, engine);
    SigmaPoints points(n, 4);
    points.factor(view(P));
    const MatrixXd e = A * points_of(points, n);
    const Result own(points, e, n, view(A)), none(points, e, n);
    // With the function's own Jacobian it is that everywhere; without one it is zero where there are no points.
    CHECK((own.M - A).norm() < 1e-6);
    std::vector<bool> is_pivot(static_cast<std::size_t>(n), false);
    for (int k = 1; k < points.count(); k += 2)
      for (int i = 0; i < n; ++i)
        if (points_of(points, n)(i, k) != 0) {
          is_pivot[static_cast<std::size_t>(i)] = true;
          break;
        }
    for (int i = 0; i < n; ++i)
      if (!is_pivot[static_cast<std::size_t>(i)]) CHECK(none.M.col(i).norm() == 0);
    const MatrixXd APAt = A * P * A.transpose();
    CHECK((own.M * P * own.M.transpose() - APAt).norm() < 1e-11 * (1 + APAt.norm()));
    CHECK((none.M * P * none.M.transpose() - APAt).norm() < 1e-11 * (1 + APAt.norm()));
    CHECK((none.M * P - A * P).norm() < 1e-11 * (1 + (A * P).norm()));
  }
}

TEST_CASE("the regression of a square and of a cube are those of a Gaussian") {
  const double sigma = 0.7;
  SigmaPoints points(1, 2);
  const MatrixXd P = MatrixXd::Constant(1, 1, sigma * sigma);
  points.factor(view(P));
  const MatrixXd xi = points_of(points, 1);
  MatrixXd e(2, 3);
  e.row(0) = xi.array().square();
  e.row(1) = xi.array().cube();
  const Result result(points, e, 1);
  CHECK(result.mean[0] == Approx(std::pow(sigma, 2)));
  CHECK(result.mean[1] == Approx(0).margin(1e-15));
  CHECK(result.M(0, 0) == Approx(0).margin(1e-15));
  CHECK(result.M(1, 0) == Approx(3 * std::pow(sigma, 2)));      // E[x x³]/E[x²]
  CHECK(result.Omega(0, 0) == Approx(2 * std::pow(sigma, 4)));  // E[x⁴] − E[x²]²
}

TEST_CASE("mean, regression and what it leaves are those of the definition") {
  std::mt19937 engine(4);
  for (int trial = 0; trial < 30; ++trial) {
    const int n = 1 + trial % 7, m = 3;
    const MatrixXd B = random_matrix(n, n, engine), P = B * B.transpose() + 0.1 * MatrixXd::Identity(n, n);
    const MatrixXd A = random_matrix(m, n, engine), C = random_matrix(m, n, engine);
    SigmaPoints points(n, m);
    points.factor(view(P));
    const MatrixXd xi = points_of(points, n);
    const VectorXd w = weights_of(points);
    const MatrixXd e = (A * xi).array().sin() + (C * xi).array().square();
    const Result result(points, e, n);
    const VectorXd mean = e * w;
    const MatrixXd off = e.colwise() - mean;
    const MatrixXd M = off * w.asDiagonal() * xi.transpose() * P.inverse();
    const MatrixXd Omega = off * w.asDiagonal() * off.transpose() - M * P * M.transpose();
    CHECK((result.mean - mean).norm() < 1e-12 * (1 + mean.norm()));
    CHECK((result.M - M).norm() < 1e-9 * (1 + M.norm()));
    CHECK((result.Omega - Omega).norm() < 1e-10 * (1 + Omega.norm()));
    CHECK((result.Omega.array() == result.Omega.transpose().array()).all());
    CHECK(Eigen::SelfAdjointEigenSolver<MatrixXd>(result.Omega).eigenvalues().minCoeff() > -1e-12 * (1 + Omega.norm()));
  }
}

TEST_CASE("a centre without weight is not read") {
  SigmaPoints points(4, 1);
  points.factor(view(MatrixXd(MatrixXd::Identity(4, 4))));
  MatrixXd e = points_of(points, 4).row(2);
  e(0, 0) = std::numeric_limits<double>::quiet_NaN();
  const Result result(points, e, 4);
  CHECK(result.mean[0] == 0);
  CHECK(result.M(0, 2) == Approx(1));
  CHECK(result.Omega(0, 0) == Approx(0).margin(1e-14));
}

TEST_CASE("what is no covariance is reported, and has no points where it is none") {
  SigmaPoints points(2, 1);
  MatrixXd P(2, 2);
  P << 1, 2, 2, 1;
  points.factor(view(P));
  CHECK(points.rank() == 1);
  CHECK(points.least_pivot() == Approx(-3));
  points.factor(view(MatrixXd(MatrixXd::Zero(2, 2))));
  CHECK(points.rank() == 0);
  CHECK(points.count() == 1);
  CHECK(points.weight(0) == 1);
  CHECK(points.least_pivot() == 1);
}

}  // namespace sigma_points_test
