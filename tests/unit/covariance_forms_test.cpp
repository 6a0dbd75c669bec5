// SPDX-License-Identifier: Apache-2.0
// The forms of the covariance against dense textbook formulas in long double, and against each other.
#include "filter/covariance_form.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>

#include <Eigen/Dense>

#include "base/aligned.hpp"
#include "catch.hpp"
#include "covariance_work.hpp"

namespace covariance_forms_test {

using namespace covariance_tests;

namespace {

using Extended = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Mask = std::vector<unsigned char>;

constexpr CovarianceKind kinds[] = {CovarianceKind::joseph, CovarianceKind::ud, CovarianceKind::square_root};

/// A form, with an arena of its own.
struct Form {
  Form(CovarianceKind its_kind, const TransitionPlan& its_plan)
      : kind(its_kind),
        n(its_plan.n),
        plan(std::make_unique<TransitionPlan>(its_plan)),
        memory(covariance_doubles(its_kind, n)),
        form(make_covariance(kind, *plan, 3, 8, memory.data())) {}
  int set(const MatrixXd& P) { return form->set({P.data(), n, n, n}); }
  MatrixXd P() const { return form->expand().as(); }
  /// Of UD: D. Else the variances.
  double least() const {
    if (kind != CovarianceKind::ud) return P().diagonal().minCoeff();
    return Eigen::Map<const VectorXd>(memory.data() + padded(n) * n, n).minCoeff();
  }
  int zeros_of_D() const {
    return static_cast<int>((Eigen::Map<const VectorXd>(memory.data() + padded(n) * n, n).array() == 0).count());
  }
  const char* update(Update& update, const Mask& corrected = {}) {
    form->project(update.columns, update.work);
    if (const char* why_not = form->factor(update.columns, update.work)) return why_not;
    form->gain(corrected, update.work);
    form->correct(corrected, update.work);
    return nullptr;
  }

  CovarianceKind kind;
  int n;
  std::unique_ptr<TransitionPlan> plan;
  internal::base::AlignedVector<double> memory;
  std::unique_ptr<CovarianceForm> form;
};

bool is_symmetric_to_the_bit(const MatrixXd& P) { return (P.array() == P.transpose().array()).all(); }

double distance(const MatrixXd& P, const Extended& expected) {
  return static_cast<double>((P.cast<long double>() - expected).norm() / (1e-300L + expected.norm()));
}

std::vector<const double*> table(const std::vector<std::vector<double>>& blocks) {
  std::vector<const double*> pointers;
  for (const auto& block : blocks) pointers.push_back(block.data());
  return pointers;
}

/// The textbook's update.
struct Expected {
  Expected(const MatrixXd& P_double, const MatrixXd& H_double, const MatrixXd& R_double, const Mask& corrected = {}) {
    const Extended P0 = P_double.cast<long double>(), H = H_double.cast<long double>(),
                   R = R_double.cast<long double>();
    S = H * P0 * H.transpose() + R;
    K = S.ldlt().solve(H * P0).transpose();
    for (std::size_t i = 0; i < corrected.size(); ++i)
      if (!corrected[i]) K.row(static_cast<int>(i)).setZero();
    const Extended A = Extended::Identity(P0.rows(), P0.rows()) - K * H;
    P = A * P0 * A.transpose() + K * R * K.transpose();
  }
  Extended S, K, P;
};

MatrixXd gain_of(const Update& update, int n) {
  return Eigen::Map<const MatrixXd>(update.K.data(), padded(n), update.m).topRows(n);
}

MatrixXd factor_of(const Update& update) {
  const int m = update.m, stride = update.work.m_max;
  return Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>>(update.L.data(), m, m, Eigen::OuterStride<>(stride))
      .triangularView<Eigen::Lower>();
}

}  // namespace

TEST_CASE("each form's step equals the dense product, for random structures") {
  for (const auto kind : kinds) {
    std::mt19937 engine(7);
    for (int trial = 0; trial < 100; ++trial) {
      const int n = 1 + static_cast<int>(engine() % 30);
      const RandomTransition transition(n, engine);
      const MatrixXd P = random_covariance(n, engine);
      Form form(kind, transition.plan);
      REQUIRE(form.set(P) == -1);
      REQUIRE(distance(form.P(), P.cast<long double>()) < 1e-14);
      for (int pass = 0; pass < 2; ++pass) {  // what its scratch holds does not matter
        REQUIRE(form.set(P) == -1);
        REQUIRE(form.form->predict(table(transition.blocks).data(), table(transition.noise).data()) == -1);
      }
      const Extended Phi = transition.Phi.cast<long double>();
      const Extended expected = Phi * P.cast<long double>() * Phi.transpose() + transition.Q.cast<long double>();
      INFO(covariance_names[static_cast<int>(kind)] << ", " << n << " rows");
      REQUIRE(distance(form.P(), expected) < 1e-14);
      REQUIRE(is_symmetric_to_the_bit(form.P()));
      REQUIRE(form.least() > 0);
    }
  }
}

TEST_CASE("each form's update equals the textbook's: rows correlated, exact, repeated, considered, left out") {
  for (const auto kind : kinds) {
    std::mt19937 engine(9);
    for (int trial = 0; trial < 200; ++trial) {
      const int n = 2 + static_cast<int>(engine() % 25), m = 1 + static_cast<int>(engine() % 6);
      const MatrixXd P = random_covariance(n, engine);
      MatrixXd H = random_matrix(m, n, engine);
      for (int c = 0; c < n; ++c)
        if (engine() % 3 == 0) H.col(c).setZero();
      // Of rank m, less, or none: exact rows are fewer than n, and so S has an inverse.
      const int rank = std::min(m, static_cast<int>(engine() % 7));
      const MatrixXd B = random_matrix(m, rank, engine);
      const MatrixXd R = rank == 0 ? MatrixXd::Zero(m, m) : MatrixXd(B * B.transpose());
      if (rank < m && m > n / 2) continue;
      const VectorXd residual = random_matrix(m, 1, engine);
      Mask corrected;
      if (trial % 2)
        for (int i = 0; i < n; ++i) corrected.push_back(engine() % 3 != 0);
      Form form(kind, identity(n));
      REQUIRE(form.set(P) == -1);
      Update update(H, R, residual, n, 6);
      const Expected expected(P, H, R, corrected);
      const double condition = static_cast<double>(Eigen::JacobiSVD<Extended>(expected.S).singularValues()(0) /
                                                   Eigen::JacobiSVD<Extended>(expected.S).singularValues()(m - 1));
      if (condition > 1e6) continue;
      REQUIRE_FALSE(form.update(update, corrected));
      INFO(covariance_names[static_cast<int>(kind)] << ", trial " << trial << ", " << n << " rows, m " << m);
      REQUIRE(distance(gain_of(update, n), expected.K) < 1e-15 * condition + 1e-13);
      REQUIRE(distance(factor_of(update) * factor_of(update).transpose(), expected.S) < 1e-13);
      REQUIRE(distance(form.P(), expected.P) < 1e-14 * condition + 1e-13);
      REQUIRE(is_symmetric_to_the_bit(form.P()));
      if (kind == CovarianceKind::ud) REQUIRE(form.least() >= 0);
      const double nis = normalized_innovation_squared(update.work);
      const auto r = residual.cast<long double>();
      const double expected_nis = static_cast<double>(r.dot(expected.S.ldlt().solve(r)));
      REQUIRE(std::abs(nis - expected_nis) < 1e-9 * (1 + expected_nis));
    }
  }
}

TEST_CASE("what was factored last is what a form corrects by: rows were left out, R changed") {
  std::mt19937 engine(12);
  const int n = 7;
  const MatrixXd P = random_covariance(n, engine), H = random_matrix(3, n, engine), R = random_covariance(3, engine);
  for (const auto kind : kinds) {
    Form form(kind, identity(n));
    REQUIRE(form.set(P) == -1);
    Update first(H, 100 * R, VectorXd::Ones(3), n, 3);
    form.form->project(first.columns, first.work);
    REQUIRE_FALSE(form.form->factor(first.columns, first.work));
    CHECK(distance(form.P(), P.cast<long double>()) < 1e-14);
    Update second(H.topRows(2), R.topLeftCorner(2, 2), VectorXd::Ones(2), n, 3);
    REQUIRE_FALSE(form.update(second));
    CHECK(distance(form.P(), Expected(P, H.topRows(2), R.topLeftCorner(2, 2)).P) < 1e-13);
  }
}

// P = U D Uᵀ of small whole numbers: every digit of it is exact, so D's zeros are.
TEST_CASE("a P that is singular stays so where nothing adds to it, and works") {
  std::mt19937 engine(21);
  for (const auto kind : kinds) {
    for (int trial = 0; trial < 50; ++trial) {
      const int n = 4 + static_cast<int>(engine() % 12);
      MatrixXd U = MatrixXd::Identity(n, n);
      VectorXd D(n);
      int zeros = 0;
      for (int j = 0; j < n; ++j) {
        D[j] = static_cast<double>(engine() % 3);
        zeros += D[j] == 0;
        for (int i = 0; i < j; ++i) U(i, j) = static_cast<double>(engine() % 5) - 2;
      }
      const MatrixXd P = U * D.asDiagonal() * U.transpose();
      Form form(kind, identity(n));
      INFO(covariance_names[static_cast<int>(kind)] << ", " << n << " rows of rank " << n - zeros);
      REQUIRE(form.set(P) == -1);
      REQUIRE(distance(form.P(), P.cast<long double>()) < 1e-14);
      if (kind == CovarianceKind::ud) REQUIRE(form.zeros_of_D() == zeros);
      const MatrixXd H = random_matrix(2, n, engine);
      Update update(H, MatrixXd::Identity(2, 2), VectorXd::Ones(2), n, 2);
      REQUIRE_FALSE(form.update(update));
      REQUIRE(distance(form.P(), Expected(P, H, MatrixXd::Identity(2, 2)).P) < 1e-12);
      if (kind == CovarianceKind::ud) REQUIRE(form.zeros_of_D() == zeros);
      if (kind == CovarianceKind::ud) REQUIRE(form.least() >= 0);
    }
  }
}

TEST_CASE("an exact measurement leaves no variance in what it saw, and can not be taken twice") {
  const MatrixXd P = Eigen::Vector3d(4, 9, 1).asDiagonal();
  MatrixXd H(1, 3);
  H << 1, 1, 0;
  for (const auto kind : {CovarianceKind::ud, CovarianceKind::square_root}) {
    Form form(kind, identity(3));
    REQUIRE(form.set(P) == -1);
    Update update(H, MatrixXd::Zero(1, 1), VectorXd::Ones(1), 3, 1);
    REQUIRE_FALSE(form.update(update));
    CHECK((H * form.P() * H.transpose()).norm() < 1e-15);
    CHECK(distance(form.P(), Expected(P, H, MatrixXd::Zero(1, 1)).P) < 1e-15);
    const char* const why_not = form.update(update);
    if (why_not) CHECK(std::string(why_not) == not_positive);
    CHECK(form.P().diagonal().minCoeff() >= 0);
  }
}

TEST_CASE("a block transformed, a variance added and P scaled are what they are of a full matrix") {
  std::mt19937 engine(5);
  const int n = 11, d = 3;
  for (const auto kind : kinds) {
    for (int first = 0; first + d <= n; ++first) {
      const MatrixXd T3 = random_matrix(d, d, engine), P = random_covariance(n, engine);
      Extended T = Extended::Identity(n, n);
      T.block(first, first, d, d) = T3.cast<long double>();
      Form form(kind, identity(n));
      REQUIRE(form.set(P) == -1);
      form.form->transform(T3.data(), first, d);
      Extended expected = T * P.cast<long double>() * T.transpose();
      REQUIRE(distance(form.P(), expected) < 1e-14);
      form.form->inflate(first, 0.7);
      expected(first, first) += 0.7L;
      REQUIRE(distance(form.P(), expected) < 1e-14);
      VectorXd scales = VectorXd::Ones(padded(n));
      scales[first] = 12;
      scales[first + 2] = 0.25;
      form.form->scale(scales.data());
      const Extended D = scales.head(n).cast<long double>().asDiagonal();
      expected = (D * expected * D).eval();
      REQUIRE(distance(form.P(), expected) < 1e-14);
      REQUIRE(is_symmetric_to_the_bit(form.P()));

      std::vector<double> some(2);
      form.form->variances({first, n - 1}, some.data());
      REQUIRE(std::abs(some[0] - form.P()(first, first)) <= 1e-14 * some[0]);
      REQUIRE(some[1] == form.form->variance(n - 1));
      const double largest = form.P().diagonal().maxCoeff();
      REQUIRE(form.form->is_below(1.01 * largest));
      REQUIRE_FALSE(form.form->is_below(0.99 * largest));
    }
  }
}

TEST_CASE("whatever comes, D is not negative, and all that a form remembers lies in its memory") {
  std::mt19937 engine(31);
  for (int trial = 0; trial < 30; ++trial) {
    const int n = 2 + static_cast<int>(engine() % 16);
    const RandomTransition transition(n, engine);
    for (const auto kind : {CovarianceKind::ud, CovarianceKind::square_root}) {
      Form form(kind, transition.plan), other(kind, transition.plan);
      MatrixXd P = random_covariance(n, engine);
      for (int i = 0; i < n; ++i) {  // from 1e-12 to 1e12
        const double scale = std::pow(10.0, static_cast<double>(engine() % 13) - 6.0);
        P.row(i) *= scale;
        P.col(i) *= scale;
      }
      REQUIRE(form.set(P) == -1);
      for (int k = 0; k < 20; ++k) {
        std::ranges::copy(form.memory, other.memory.begin());  // as from a snapshot
        const MatrixXd H = random_matrix(2, n, engine);
        for (Form* its : {&form, &other}) {
          REQUIRE(its->form->predict(table(transition.blocks).data(), table(transition.noise).data()) == -1);
          Update update(H, 1e-8 * MatrixXd::Identity(2, 2), VectorXd::Ones(2), n, 2);
          REQUIRE_FALSE(its->update(update));
          REQUIRE(its->least() >= 0);
        }
        REQUIRE(other.memory == form.memory);
        REQUIRE(other.P() == form.P());
      }
    }
  }
}

TEST_CASE("what is no covariance is named by its row, and changes nothing") {
  MatrixXd P = Eigen::Vector4d(1, 2, 3, 4).asDiagonal();
  TransitionPlan plan;
  plan.n = 4;
  plan.noise = {{0, 0, places(2), places(2, 2), 0}, {3, 3, places(1), {}, 1}};
  finish(plan);
  for (const auto kind : {CovarianceKind::ud, CovarianceKind::square_root}) {
    Form form(kind, plan);
    REQUIRE(form.set(P) == -1);
    const auto kept = form.memory;
    MatrixXd wrong = P;
    wrong(2, 0) = wrong(0, 2) = 2;  // of variances 1 and 3
    CHECK(form.set(wrong) == 0);
    wrong = P;
    wrong(1, 1) = -1e-9;
    CHECK(form.set(wrong) == 1);
    wrong(1, 1) = std::nan("");
    CHECK(form.set(wrong) == 1);
    wrong(1, 1) = 0;
    wrong(1, 3) = wrong(3, 1) = 0.1;
    CHECK(form.set(wrong) == 1);
    CHECK(form.memory == kept);

    const auto predict = [&](std::vector<double> block, double q) {
      const double* const noise[] = {block.data(), &q};
      return form.form->predict(nullptr, noise);
    };
    CHECK(predict({1, 2, 2, 1}, 0) == 1);
    CHECK(predict({1, 0, 0, 1}, -1e-9) == 3);
    CHECK(form.memory == kept);
    CHECK(predict({1, 1, 1, 1}, -1e-14) == -1);  // rounding, next to the variance 4
    CHECK(distance(form.P(), (P + (MatrixXd(4, 4) << 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0).finished())
                                 .cast<long double>()) < 1e-15);
    // And what is infinite ends in the health check.
    CHECK(form.form->is_below(1e30));
    CHECK(predict({1, 0, 0, 1}, std::numeric_limits<double>::infinity()) == 3);

    MatrixXd H = MatrixXd::Identity(2, 4), R(2, 2);
    R << 1, 2, 2, 1;
    Update update(H, R, VectorXd::Ones(2), 4, 2);
    CHECK(std::string(form.update(update)) == "R is not positive semidefinite");
  }
}

TEST_CASE("a factor that is not finite is seen") {
  TransitionPlan plan;
  plan.n = 3;
  plan.diagonals = {{1, 0, 0}};
  finish(plan);
  for (const auto kind : kinds) {
    Form form(kind, plan);
    REQUIRE(form.set(MatrixXd::Identity(3, 3)) == -1);
    const double bad = std::nan("");
    const double* const phi[] = {&bad};
    REQUIRE(form.form->predict(phi, nullptr) == -1);
    CHECK_FALSE(form.form->is_below(1e30));
    CHECK(std::isnan(form.form->variance(1)));
  }
}

TEST_CASE("on random linear filters the three forms agree to 1e-9 of sigma") {
  std::mt19937 engine(17);
  for (int trial = 0; trial < 20; ++trial) {
    const int n = 2 + static_cast<int>(engine() % 18);
    RandomTransition transition(n, engine);
    for (auto& block : transition.blocks)
      for (double& element : block) element *= 0.9 / std::sqrt(n);
    std::vector<Form> forms;
    for (const auto kind : kinds) forms.emplace_back(kind, transition.plan);
    const MatrixXd P = random_covariance(n, engine);
    for (auto& form : forms) REQUIRE(form.set(P) == -1);
    VectorXd x[3] = {VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n)};
    for (int step = 0; step < 200; ++step) {
      const int m = 1 + static_cast<int>(engine() % 4);
      const MatrixXd H = random_matrix(m, n, engine), R = random_covariance(m, engine);
      const VectorXd z = 10 * random_matrix(m, 1, engine);
      Mask corrected;
      if (trial % 3 == 0)
        for (int i = 0; i < n; ++i) corrected.push_back(i % 4 != 0);
      for (int f = 0; f < 3; ++f) {
        REQUIRE(forms[static_cast<std::size_t>(f)].form->predict(table(transition.blocks).data(),
                                                                 table(transition.noise).data()) == -1);
        Update update(H, R, z - H * x[f], n, 4);
        REQUIRE_FALSE(forms[static_cast<std::size_t>(f)].update(update, corrected));
        VectorXd delta(padded(n));
        gain_times_residual(n, update.work, delta.data());
        x[f] += delta.head(n);
      }
      const VectorXd sigma = forms[0].P().diagonal().cwiseSqrt();
      for (const int f : {1, 2}) {
        const VectorXd its = forms[static_cast<std::size_t>(f)].P().diagonal().cwiseSqrt();
        REQUIRE(((its - sigma).array() / sigma.array()).abs().maxCoeff() < 1e-9);
        REQUIRE(((x[f] - x[0]).array() / sigma.array()).abs().maxCoeff() < 1e-9);
      }
    }
  }
}

// Two rows see the same sum of two components that nothing is known of: H P Hᵀ + R is singular in doubles. What a factor
// keeps is the sum to a part of prior · ε² of its variance, and the rest to a part of √prior ε of its sigma.
TEST_CASE("rows that see the same of a prior of 1e20 are told apart by the factored forms, and not by Joseph's") {
  const double prior = 1e20;
  const MatrixXd P = Eigen::Vector2d(prior, prior).asDiagonal();
  MatrixXd H(2, 2), second(1, 2);
  H << 1, 1, 1, 1;
  second << 1, -1;
  for (const auto kind : {CovarianceKind::ud, CovarianceKind::square_root}) {
    Form form(kind, identity(2));
    REQUIRE(form.set(P) == -1);
    Update both(H, MatrixXd::Identity(2, 2), Eigen::Vector2d(1, 3), 2, 2);
    REQUIRE_FALSE(form.update(both));
    VectorXd delta(padded(2));
    gain_times_residual(2, both.work, delta.data());
    CHECK(std::abs(delta[0] + delta[1] - 2) < 1e-5);
    CHECK(std::abs(delta[0] - delta[1]) < 1e-5 * std::sqrt(prior));
    // S = 2e20 (1, 1; 1, 1) + I: what the rows contradict each other by is seen.
    CHECK(std::abs(normalized_innovation_squared(both.work) - 2) < 1e-10);
    Update difference(second, MatrixXd::Identity(1, 1), VectorXd::Zero(1), 2, 2);
    REQUIRE_FALSE(form.update(difference));
    // x0 + x1 has the variance 1/2, x0 − x1 the variance 1.
    const MatrixXd expected = (MatrixXd(2, 2) << 0.375, -0.125, -0.125, 0.375).finished();
    CHECK((form.P() - expected).norm() < 1e-10);
  }
  Form joseph(CovarianceKind::joseph, identity(2));
  REQUIRE(joseph.set(P) == -1);
  Update both(H, MatrixXd::Identity(2, 2), Eigen::Vector2d(1, 3), 2, 2);
  const bool is_refused = joseph.update(both) != nullptr;
  CHECK((is_refused || std::abs(normalized_innovation_squared(both.work) - 2) > 1));
}

// The step is where Gram and Schmidt's subtraction would lose them: a velocity of 1e15 next to a position of 1.
TEST_CASE("a step mixes a variance of 1e30 into one of 1 and keeps what is left of that") {
  TransitionPlan plan;
  plan.n = 2;
  plan.groups = {RowGroup{1, 1, {{0, 0, 0}, {1, 0, 1}}, {}}};  // velocity first, then position
  finish(plan);
  const double block[] = {0.5, 1};
  const double* const phi[] = {block};
  const MatrixXd P = Eigen::Vector2d(1e30, 1).asDiagonal();
  MatrixXd H(1, 2);
  H << 0, 1;
  for (const auto kind : {CovarianceKind::ud, CovarianceKind::square_root}) {
    Form form(kind, plan);
    REQUIRE(form.set(P) == -1);
    REQUIRE(form.form->predict(phi, nullptr) == -1);
    Update update(H, MatrixXd::Identity(1, 1), VectorXd::Zero(1), 2, 1);
    REQUIRE_FALSE(form.update(update));
    // velocity = (z − position before) / 0.5 with the variance (1 + 1) / 0.25.
    const MatrixXd expected = (MatrixXd(2, 2) << 8, 2, 2, 1).finished();
    CHECK((form.P() - expected).norm() < 1e-13);
  }
}

}  // namespace covariance_forms_test
