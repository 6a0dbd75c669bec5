// SPDX-License-Identifier: Apache-2.0
// NEES of the whole state: against dense algebra, with P of less than full rank, and what it finds that no block's own does.
#include "../../sdk/score/state_nees.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>

#include "catch.hpp"

namespace state_nees_test {

using namespace binnacle;
using namespace binnacle::score;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd random_matrix(int rows, int columns, std::mt19937& engine) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(engine); });
}

BlockInfo block(const char* name, int first_row, std::vector<int> active) {
  BlockInfo info;
  info.name = name;
  info.first_row = first_row;
  info.active = std::move(active);
  return info;
}

ConstMatrixView view(const MatrixXd& P) {
  const int n = static_cast<int>(P.rows());
  return {P.data(), n, n, n};
}

/// Two blocks, of two and three components; of the second the middle one is frozen and has no row in P.
struct Two {
  BlockInfo a = block("a", 1, {0, 1}), b = block("b", 3, {0, 2});
  StateNees nees;
  int part_a = nees.add(a), part_b = nees.add(b);

  void take(Time t, const VectorXd& delta, const MatrixXd& P) {
    const double of_a[] = {delta[1], delta[2]}, of_b[] = {delta[3], 1e9, delta[4]};
    nees.take(part_a, t, 1, of_a, view(P));
    nees.take(part_b, t, 1, of_b, view(P));
  }
};

}  // namespace

TEST_CASE("state NEES: of the rows of its blocks, by the inverse of their part of P") {
  std::mt19937 engine(1);
  for (int i = 0; i < 50; ++i) {
    const MatrixXd A = random_matrix(6, 6, engine);
    // Units of very different sizes.
    const VectorXd scale = (VectorXd(6) << 1, 1e-7, 1e6, 1e-9, 3, 1).finished();
    const MatrixXd P = scale.asDiagonal() * (A * A.transpose()) * scale.asDiagonal();
    const VectorXd delta = scale.cwiseProduct(random_matrix(6, 1, engine));
    Two two;
    two.take(5, delta, P);
    REQUIRE(two.nees.nees().values.size() == 1);
    const VectorXd d = scale.cwiseInverse().cwiseProduct(delta).segment(1, 4);
    const MatrixXd C = (A * A.transpose()).block(1, 1, 4, 4);
    const double wanted = d.dot(C.fullPivLu().solve(d));
    CHECK(std::abs(two.nees.nees().values[0] / wanted - 1) < 1e-8);
    CHECK(two.nees.dof().values[0] == 4);
    CHECK(two.nees.nees().t[0] == 5);
    CHECK(std::abs(ranked_nees(MatrixXd(P.block(1, 1, 4, 4)).data(), delta.data() + 1, 4).nees / wanted - 1) < 1e-6);
  }
  CHECK(Two().nees.blocks() == std::vector<std::string>{"a", "b"});
}

TEST_CASE("state NEES: only where all blocks are given, of one time and one estimate") {
  const MatrixXd P = MatrixXd::Identity(6, 6);
  const double of_a[] = {1, 2}, of_b[] = {3, 0, 4};
  Two two;
  two.nees.take(two.part_a, 1, 1, of_a, view(P));
  two.nees.take(two.part_a, 2, 1, of_a, view(P));
  two.nees.take(two.part_b, 3, 1, of_b, view(P));
  two.nees.take(two.part_a, 3, 2, of_a, view(P));  // another estimate
  CHECK(two.nees.nees().t.empty());
  two.nees.take(two.part_a, 3, 2, of_a, view(P));
  two.nees.take(two.part_b, 3, 2, of_b, view(P));
  CHECK(two.nees.nees().values == std::vector<double>{30});
  two.nees.take(two.part_b, 3, 2, of_b, view(P));  // the next pair has begun
  CHECK(two.nees.nees().values.size() == 1);
}

TEST_CASE("state NEES: a block without a component that has a variance takes no part") {
  StateNees nees;
  const BlockInfo frozen = block("frozen", -1, {});
  CHECK(nees.add(frozen) == -1);
  CHECK_FALSE(nees.is_there());
}

TEST_CASE("state NEES: of a singular P the rank is counted") {
  std::mt19937 engine(2);
  std::normal_distribution<double> normal;
  const boost::math::chi_squared distribution(2.0 * 500);
  double sum = 0;
  for (int i = 0; i < 500; ++i) {
    // A copy: its error is that of what it is of.
    MatrixXd P = MatrixXd::Zero(6, 6);
    const MatrixXd A = random_matrix(2, 2, engine), C = A * A.transpose();
    P.block(1, 1, 2, 2) = P.block(3, 3, 2, 2) = P.block(1, 3, 2, 2) = P.block(3, 1, 2, 2) = C;
    const VectorXd error = A * random_matrix(2, 1, engine);
    VectorXd delta = VectorXd::Zero(6);
    delta << 0, error, error, 0;
    Two two;
    two.take(0, delta, P);
    REQUIRE(two.nees.dof().values[0] == 2);
    const double wanted = error.dot(C.fullPivLu().solve(error));
    REQUIRE(std::abs(two.nees.nees().values[0] / wanted - 1) < 1e-6);
    sum += wanted;
    // A copy that is elsewhere is what P rules out.
    delta[4] += 0.01 * std::sqrt(C(1, 1));
    two.take(1, delta, P);
    REQUIRE(two.nees.dof().values[1] == 2);
    REQUIRE(two.nees.nees().values[1] > 1e6);
  }
  CHECK(sum > boost::math::quantile(distribution, 0.005));
  CHECK(sum < boost::math::quantile(boost::math::complement(distribution, 0.005)));
}

TEST_CASE("state NEES: a component of variance 0 is no degree of freedom unless it errs") {
  MatrixXd P = MatrixXd::Identity(6, 6);
  P(4, 4) = 0;
  Two two;
  two.take(0, (VectorXd(6) << 0, 1, 1, 1, 0, 0).finished(), P);
  two.take(1, (VectorXd(6) << 0, 1, 1, 1, 1e-3, 0).finished(), P);
  CHECK(std::abs(two.nees.nees().values[0] - 3) < 1e-12);
  CHECK(two.nees.nees().values[1] > 1e6);
  CHECK(two.nees.dof().values == std::vector<double>{3, 3});
}

TEST_CASE("state NEES: a wrong cross-covariance is found, though each block's own NEES is right") {
  constexpr int runs = 2000;
  std::mt19937 engine(3);
  MatrixXd P = MatrixXd::Identity(6, 6);
  P(1, 3) = P(3, 1) = 0.7;
  P(2, 4) = P(4, 2) = -0.5;
  const MatrixXd L = P.llt().matrixL();
  MatrixXd wrong = P;
  wrong(1, 3) = wrong(3, 1) = -0.7;
  Two right_filter, wrong_filter;
  double of_a = 0, of_b = 0;
  for (int run = 0; run < runs; ++run) {
    const VectorXd delta = L * random_matrix(6, 1, engine);
    right_filter.take(run, delta, P);
    wrong_filter.take(run, delta, wrong);
    of_a += delta.segment(1, 2).squaredNorm() / runs;  // both have the identity for each block
    of_b += delta.segment(3, 2).squaredNorm() / runs;
  }
  const auto band = [](double dof) {
    const boost::math::chi_squared distribution(dof * runs);
    return std::pair(boost::math::quantile(distribution, 0.005) / runs,
                     boost::math::quantile(boost::math::complement(distribution, 0.005)) / runs);
  };
  const auto mean = [](const StateNees& nees) {
    double sum = 0;
    for (const double value : nees.nees().values) sum += value / runs;
    return sum;
  };
  const auto is_inside = [](double value, std::pair<double, double> of) {
    return of.first < value && value < of.second;
  };
  CAPTURE(of_a, of_b, mean(right_filter.nees), mean(wrong_filter.nees));
  CHECK(is_inside(of_a, band(2)));
  CHECK(is_inside(of_b, band(2)));
  CHECK(is_inside(mean(right_filter.nees), band(4)));
  // tr(P_wrong⁻¹ P) = 2 (1 + ρ²)/(1 − ρ²) + 2
  CHECK(std::abs(mean(wrong_filter.nees) / (2 * 1.49 / 0.51 + 2) - 1) < 0.1);
}

}  // namespace state_nees_test
