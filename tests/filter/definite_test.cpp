// SPDX-License-Identifier: Apache-2.0
// Health beyond the diagonal: correlations beyond one, an indefinite P, and updates that an expanded P has no digits for.
#include "filter/definite.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace definite_test {

using namespace binnacle;
using Eigen::MatrixXd;
using filter_tests::composition_of;
using filter_tests::from_covariance;
using filter_tests::push;
using filter_tests::started_with;
using filter_tests::with_form;
using internal::filter::indefinite_row;

namespace {

internal::filter::VarianceLeft look(const MatrixXd& P) {
  std::vector<double> factor(static_cast<std::size_t>(P.size()));
  const int n = static_cast<int>(P.rows());
  return indefinite_row({P.data(), n, n, n}, factor.data());
}

std::string with_sigmas(double start, double noise) {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": )" +
         std::to_string(start) + R"(}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [)" +
         std::to_string(noise) + R"(]}}}}})";
}

const Diagnostic* doubt(const Diagnostics& doubts, const char* code) {
  const auto found = std::ranges::find(doubts.items(), code, &Diagnostic::code);
  return found == doubts.items().end() ? nullptr : &*found;
}

}  // namespace

TEST_CASE("an indefinite P is found by the row where it becomes so, and by how much") {
  MatrixXd P(2, 2);
  P << 4, 3, 3, 9;
  CHECK(look(P).row == -1);
  P << 4, 9, 9, 9;  // a correlation of 1.5
  CHECK(look(P).row == 1);
  CHECK(look(P).share == Approx(1 - 1.5 * 1.5));
  MatrixXd Q(3, 3);  // no pair of them is beyond one
  Q << 1, 0.9, -0.9, 0.9, 1, 0.9, -0.9, 0.9, 1;
  CHECK(look(Q).row == 2);
  CHECK(look(Q).share < -1);
  CHECK(Q.eigenvalues().real().minCoeff() < 0);
}

TEST_CASE("exact knowledge is no fault of P: zeros, copies, and what rounding makes of them") {
  CHECK(look(MatrixXd::Zero(3, 3)).row == -1);
  CHECK(look(MatrixXd::Ones(3, 3)).row == -1);
  MatrixXd P(2, 2);
  P << 0, 1e-9, 1e-9, 1;
  CHECK(look(P).row == 1);  // a covariance with what is known
  P << 1, 1 + 1e-8, 1 + 1e-8, 1;
  CHECK(look(P).row == -1);
  P << 1, 1 + 1e-5, 1 + 1e-5, 1;
  CHECK(look(P).row == 1);
}

TEST_CASE("P as eigenvalues see it: 500 of either kind") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  int indefinite = 0;
  for (int k = 0; k < 500; ++k) {
    const int n = 2 + k % 8;
    MatrixXd A(n, n);
    for (double& a : A.reshaped()) a = normal(random);
    Eigen::VectorXd d(n);
    for (double& value : d) value = std::abs(normal(random)) + 0.1;
    if (k % 2 == 0) d[0] = -0.3;
    MatrixXd P = A * d.asDiagonal() * A.transpose();
    P = (0.5 * (P + P.transpose())).eval();
    if (P.diagonal().minCoeff() <= 0) continue;  // the diagonal says so
    const Eigen::VectorXd scale = P.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd C = scale.asDiagonal() * P * scale.asDiagonal();
    const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(C).eigenvalues()[0];
    if (std::abs(least) < 1e-5) continue;  // either may be said
    const bool is_indefinite = least < 0;
    indefinite += is_indefinite;
    CAPTURE(k, n);
    CHECK((look(P).row >= 0) == is_indefinite);
  }
  CHECK(indefinite > 50);
}

TEST_CASE("a correlation beyond one makes a filter lost, with the component's name") {
  const Session right = started_with(0.5), wrong = started_with(1.5);
  CHECK(right.verdict({0}) == Verdict::ok);
  CHECK(wrong.verdict({0}) == Verdict::lost);
  const Diagnostics doubts = wrong.doubts({0});
  REQUIRE(doubt(doubts, "B126"));
  CHECK(doubt(doubts, "B126")->message.find("'x.x1' has -1.25 of its variance left") != std::string::npos);
}

TEST_CASE("P is looked at now and then: what it was is reported at the end, though it has become a covariance") {
  std::string config = from_covariance();
  const auto put = [&](const std::string& what, const std::string& instead) {
    config.replace(config.find(what), what.size(), instead);
  };
  put(R"("random_constant", "blocks": {"x": "x"})", R"("random_walk", "blocks": {"x": "x"}, "q": 0.01)");
  put("[1, 1]", "[1e6, 1e6]");
  for (const int steps : {1000, 1100}) {
    Session session = started_with(1.5, config);
    const double z[] = {0, 0};
    for (int k = 1; k <= steps; ++k) session.push(session.channel("z"), no_time, nanoseconds(k), z);
    CHECK(session.verdict({0}) == Verdict::lost);  // now
    session.push(session.channel("z"), no_time, nanoseconds(1e6), z);
    const Diagnostics doubts = session.doubts({0});
    CAPTURE(steps);
    CHECK((doubt(doubts, "B126") != nullptr) == (steps > 1024));
    if (steps > 1024) CHECK(doubt(doubts, "B126")->message.find("first at 1024.0 s") != std::string::npos);
  }
}

TEST_CASE("an update that an expanded P has no digits for is reported with the forms that hold it") {
  for (const char* form : {"joseph", "ud", "square_root"}) {
    CAPTURE(form);
    const bool is_expanded = std::string(form) == "joseph";
    for (const double start : {1e6, 1e8, 1e10}) {
      Session session(composition_of(with_form(with_sigmas(start, 1), form)));
      for (int k = 1; k < 5; ++k) push(session, "z", k, {3});
      const Diagnostics doubts = session.doubts({0});
      CAPTURE(start, session.covariance(FilterId{0})(0, 0));
      CHECK((doubt(doubts, "B127") != nullptr) == (is_expanded && start > 3e7));
      CHECK(session.verdict({0}) == (is_expanded && start > 3e7 ? Verdict::doubtful : Verdict::ok));
      // Where nothing is said, the variance is right: that of four fixes.
      if (!doubt(doubts, "B127")) CHECK(session.covariance(FilterId{0})(0, 0) == Approx(0.25).epsilon(1e-3));
      if (doubt(doubts, "B127"))
        CHECK(doubt(doubts, "B127")->message.find("\"ud\" and \"square_root\" have enough") != std::string::npos);
    }
  }
}

}  // namespace definite_test
