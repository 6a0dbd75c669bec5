// SPDX-License-Identifier: Apache-2.0
// The sparse covariance arithmetic against dense textbook formulas.
#include <cmath>
#include <cstring>
#include <random>

#include <Eigen/Dense>

#include "catch.hpp"
#include "covariance_work.hpp"
#include "filter/covariance.hpp"
#include "filter/estimator.hpp"
#include "filter/model_calls.hpp"
#include "filter/strip_loops.hpp"

namespace covariance_test {

using namespace binnacle;
using namespace binnacle::internal::filter;
using namespace covariance_tests;

TEST_CASE("predict equals the dense product for random structures") {
  std::mt19937 engine(7);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + static_cast<int>(engine() % 30);
    const int coupled_first = trial % 2 ? -1 : static_cast<int>(engine() % static_cast<unsigned>(n + 1));
    const RandomTransition transition(n, engine, coupled_first);
    const auto& [Phi, Q, plan, blocks, noise] = transition;
    std::vector<const double*> phi_table, noise_table;
    for (const auto& block : blocks) phi_table.push_back(block.data());
    for (const auto& block : noise) noise_table.push_back(block.data());

    const MatrixXd P = random_covariance(n, engine);
    const Stored given(P);
    Stored stored(P);
    Joseph form(plan, 1, stored.data.data());
    for (int pass = 0; pass < 2; ++pass) {  // what its scratch holds at first does not matter
      stored.data = given.data;             // in place
      form.predict(phi_table.data(), noise_table.data());
    }

    const MatrixXd expected = Phi * P * Phi.transpose() + Q;
    REQUIRE((stored.matrix() - expected).norm() < 1e-12 * expected.norm());
    REQUIRE(stored.is_symmetric_to_the_bit());
    REQUIRE(stored.padding_is_zero());
  }
}

TEST_CASE("the update equals Joseph's form, also with considered states") {
  std::mt19937 engine(11);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + static_cast<int>(engine() % 25);
    const int m = 1 + static_cast<int>(engine() % 7);
    const int m_max = m + static_cast<int>(engine() % 3);
    MatrixXd H = random_matrix(m, n, engine);
    for (int c = 1; c < n; ++c)
      if (engine() % 2) H.col(c).setZero();
    const MatrixXd R = random_covariance(m, engine);
    const MatrixXd P = random_covariance(n, engine);
    const VectorXd residual = random_matrix(m, 1, engine);
    std::vector<unsigned char> corrected(static_cast<std::size_t>(n), 1);
    const bool considers = trial % 2;
    if (considers)
      for (auto& flag : corrected) flag = engine() % 3 != 0;

    Stored stored(P);
    Update update(H, R, residual, n, m_max);
    const TransitionPlan plan = identity(n);
    Joseph form(plan, 1, stored.data.data());
    form.project(update.columns, update.work);
    REQUIRE_FALSE(form.factor(update.columns, update.work));
    const double nis = normalized_innovation_squared(update.work);
    const auto mask = considers ? corrected : std::vector<unsigned char>();
    form.gain(mask, update.work);
    form.correct(mask, update.work);
    VectorXd delta(padded(n));
    gain_times_residual(n, update.work, delta.data());
    delta.conservativeResize(n);

    const MatrixXd S = H * P * H.transpose() + R;
    MatrixXd K = P * H.transpose() * S.inverse();
    for (int i = 0; i < n; ++i)
      if (!corrected[static_cast<std::size_t>(i)]) K.row(i).setZero();
    const MatrixXd A = MatrixXd::Identity(n, n) - K * H;
    const MatrixXd expected = A * P * A.transpose() + K * R * K.transpose();
    REQUIRE(std::abs(nis - residual.dot(S.inverse() * residual)) < 1e-9 * (1 + nis));
    REQUIRE((delta - K * residual).norm() < 1e-9 * (1 + delta.norm()));
    REQUIRE((stored.matrix() - expected).norm() < 1e-11 * P.norm());
    REQUIRE(stored.is_symmetric_to_the_bit());
  }
}

TEST_CASE("every instruction set gives the same bits") {
  if (!runs_avx2()) return;  // one set only
  std::mt19937 engine(11);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + static_cast<int>(engine() % 40), ld = padded(n), m = 1 + static_cast<int>(engine() % 6);
    const auto doubles = [&](int count) {
      std::vector<double> list(static_cast<std::size_t>(count));
      for (double& x : list) x = std::normal_distribution<double>()(engine);
      return list;
    };
    const auto in = doubles(ld * n), coefficients = doubles(3 * n);
    std::vector<int> columns;
    for (int c = 0; c < n; ++c)
      if (engine() % 3 > 0) columns.push_back(c);
    const int count = static_cast<int>(columns.size()), first = static_cast<int>(engine() % 3) * strip % ld;
    for (int rows = 1; rows <= 3; ++rows) {
      std::vector<double> one(static_cast<std::size_t>(3 * ld)), other(one);
      base_strip_loops.combine(rows, in.data(), ld, first, count, columns.data(), coefficients.data(), 3, one.data());
      avx2_strip_loops.combine(rows, in.data(), ld, first, count, columns.data(), coefficients.data(), 3, other.data());
      REQUIRE(std::memcmp(one.data(), other.data(), one.size() * sizeof(double)) == 0);
    }
    auto P1 = in, P2 = in, K1 = doubles(ld * m), U1 = K1, K2 = K1, U2 = K1;
    auto G = doubles(ld * m), S = doubles(m * m), L = doubles(m * m);
    const auto work = [&](std::vector<double>& K, std::vector<double>& U) {
      UpdateWork w;
      w.m = w.m_max = m;
      w.G = G.data();
      w.S = S.data();
      w.L = L.data();
      w.K = K.data();
      w.U = U.data();
      return w;
    };
    base_strip_loops.gain(n, work(K1, U1));
    avx2_strip_loops.gain(n, work(K2, U2));
    base_strip_loops.correct(P1.data(), n, work(K1, U1));
    avx2_strip_loops.correct(P2.data(), n, work(K2, U2));
    REQUIRE(std::memcmp(P1.data(), P2.data(), P1.size() * sizeof(double)) == 0);
    REQUIRE(std::memcmp(K1.data(), K2.data(), K1.size() * sizeof(double)) == 0);
    base_strip_loops.mirror(P1.data(), n);
    avx2_strip_loops.mirror(P2.data(), n);
    REQUIRE(std::memcmp(P1.data(), P2.data(), P1.size() * sizeof(double)) == 0);
    auto T1 = doubles(ld * ld), T2 = T1;
    const auto square = doubles(ld * ld);
    base_strip_loops.transpose(square.data(), ld, ld, T1.data(), ld);
    avx2_strip_loops.transpose(square.data(), ld, ld, T2.data(), ld);
    REQUIRE(T1 == T2);
    for (int j = 0; j < ld; ++j)
      for (int i = 0; i < ld; ++i)
        REQUIRE(T1[static_cast<std::size_t>(j + i * ld)] == square[static_cast<std::size_t>(i + j * ld)]);
  }
}

TEST_CASE("every instruction set puts the same prediction together") {
  if (!runs_avx2()) return;  // one set only
  std::mt19937 engine(13);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + static_cast<int>(engine() % 40), ld = padded(n);
    const auto doubles = [&](int count) {
      std::vector<double> list(static_cast<std::size_t>(count));
      for (double& x : list) x = std::normal_distribution<double>()(engine);
      return list;
    };
    const RandomTransition transition(n, engine);
    const TransitionPlan& plan = transition.plan;
    const auto M = doubles(ld * ld), AA = doubles(ld * ld), d = doubles(ld);
    const auto runs = [](const std::vector<RowRun>& of) { return RowRuns{of.data(), static_cast<int>(of.size())}; };
    const PredictedParts parts{
        ld, padded(plan.coupled_rows), runs(plan.coupled), runs(plan.uncoupled), n, d.data(), M.data(), AA.data()};
    auto P1 = doubles(ld * n), P2 = P1;
    base_strip_loops.store(P1.data(), parts);
    avx2_strip_loops.store(P2.data(), parts);
    for (int j = 0; j < n; ++j) {  // what is above the diagonal is written over
      const auto lower = [&](const std::vector<double>& P) { return P.data() + j * ld + j; };
      REQUIRE(std::memcmp(lower(P1), lower(P2), static_cast<std::size_t>(n - j) * sizeof(double)) == 0);
    }
  }
}

TEST_CASE("coupled rows that are the first ones are predicted in place, to the same bits") {
  std::mt19937 engine(17);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + static_cast<int>(engine() % 40), ld = padded(n);
    const int coupled = 1 + static_cast<int>(engine() % static_cast<unsigned>(n));
    const RandomTransition transition(n, engine, coupled);
    const TransitionPlan& plan = transition.plan;
    REQUIRE(plan.coupled.size() == 1);
    std::vector<const double*> phi;
    for (const auto& block : transition.blocks) phi.push_back(block.data());
    std::vector<std::vector<double>> coefficients;
    std::vector<CombinedRows> groups;
    for (const auto& group : plan.groups) {
      auto& own = coefficients.emplace_back(1 + group.columns.size() * static_cast<std::size_t>(group.rows));
      collect(group, phi.data(), own.data());
      groups.push_back({group.rows, static_cast<int>(group.indices.size()), group.indices.data(), own.data()});
    }
    const int ld_coupled = padded(plan.coupled_rows);
    const auto doubles = [](int count) { return std::vector<double>(static_cast<std::size_t>(count)); };
    auto d = doubles(ld);
    for (double& own : d) own = 1;
    for (const auto& diagonal : plan.diagonals)
      d[static_cast<std::size_t>(diagonal.row)] = phi[static_cast<std::size_t>(diagonal.block)][diagonal.offset];
    const Stored given(random_covariance(n, engine));
    const auto runs = [](const std::vector<RowRun>& of) { return RowRuns{of.data(), static_cast<int>(of.size())}; };
    const auto predicted = [&](const StripLoops& loops, bool in_place) {
      Stored P = given;
      auto M = doubles(ld * ld_coupled), Mt = M, AA = doubles(ld_coupled * ld_coupled);
      double* const P_data = P.data.data();
      loops.couple(P_data, {ld, ld_coupled, groups.data(), static_cast<int>(groups.size()), M.data(), Mt.data(),
                            in_place ? P_data : AA.data(), in_place ? ld : ld_coupled});
      loops.store(P_data, {ld, ld_coupled, runs(plan.coupled), runs(plan.uncoupled), plan.scaled_rows, d.data(),
                           M.data(), in_place ? nullptr : AA.data()});
      loops.mirror(P_data, n);
      return P.data;
    };
    const auto expected = predicted(base_strip_loops, false);
    const auto is_expected = [&](const auto& P) {
      return std::memcmp(P.data(), expected.data(), expected.size() * sizeof(double)) == 0;
    };
    REQUIRE(is_expected(predicted(base_strip_loops, true)));
    if (!runs_avx2()) continue;
    REQUIRE(is_expected(predicted(avx2_strip_loops, false)));
    REQUIRE(is_expected(predicted(avx2_strip_loops, true)));
  }
}

TEST_CASE("an innovation covariance that is not positive definite is refused") {
  const MatrixXd P = MatrixXd::Identity(2, 2);
  Stored stored(P);
  MatrixXd H(1, 2);
  H << 1, 0;
  Update update(H, MatrixXd::Constant(1, 1, -2.0), VectorXd::Ones(1), 2, 1);
  const TransitionPlan plan = identity(2);
  Joseph form(plan, 1, stored.data.data());
  form.project(update.columns, update.work);
  REQUIRE(form.factor(update.columns, update.work));
}

TEST_CASE("a block of P is transformed as T P T'") {
  std::mt19937 engine(5);
  const int n = 11, d = 3;
  for (int first = 0; first + d <= n; ++first) {
    const MatrixXd T3 = random_matrix(d, d, engine);
    MatrixXd T = MatrixXd::Identity(n, n);
    T.block(first, first, d, d) = T3;
    const MatrixXd P = random_covariance(n, engine);
    Stored stored(P);
    const TransitionPlan plan = identity(n);
    Joseph(plan, d, stored.data.data()).transform(T3.data(), first, d);
    REQUIRE((stored.matrix() - T * P * T.transpose()).norm() < 1e-12 * P.norm() * T.squaredNorm());
    REQUIRE(stored.is_symmetric_to_the_bit());
    REQUIRE(stored.padding_is_zero());
  }
}

TEST_CASE("discretize equals a fine integration, stiff and unstable models included") {
  std::mt19937 engine(3);
  for (const double stiffness : {0.01, 1.0, 40.0}) {
    const int n = 5;
    MatrixXd F = random_matrix(n, n, engine);
    F -= stiffness * MatrixXd::Identity(n, n);
    const MatrixXd G = random_matrix(n, 2, engine);
    const MatrixXd Q = G * G.transpose();
    const double dt = 0.7;
    MatrixXd Phi(n, n), Qd(n, n);
    std::vector<double> work(van_loan_matrices * static_cast<std::size_t>(n * n));
    discretize(F.data(), Q.data(), n, dt, Phi.data(), Qd.data(), work.data());

    // Ẋ = F X and Ṗ = F P + P Fᵀ + Q by the classical fourth-order rule with small steps.
    MatrixXd X = MatrixXd::Identity(n, n), P = MatrixXd::Zero(n, n);
    const int steps = 20000;
    const double h = dt / steps;
    const auto P_dot = [&](const MatrixXd& p) -> MatrixXd { return F * p + p * F.transpose() + Q; };
    for (int i = 0; i < steps; ++i) {
      const MatrixXd a = F * X, b = F * (X + h / 2 * a), c = F * (X + h / 2 * b), d = F * (X + h * c);
      X += h / 6 * (a + 2 * b + 2 * c + d);
      const MatrixXd k1 = P_dot(P), k2 = P_dot(P + h / 2 * k1), k3 = P_dot(P + h / 2 * k2), k4 = P_dot(P + h * k3);
      P += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    REQUIRE((Phi - X).norm() < 1e-10 * (1 + X.norm()));
    REQUIRE((Qd - P).norm() < 1e-10 * (1 + P.norm()));
    REQUIRE((Qd - Qd.transpose()).norm() == 0);
  }
}

TEST_CASE("Joseph's form keeps P in the memory that it is given, and gives it back whole") {
  std::mt19937 engine(3);
  const int n = 7;
  const TransitionPlan plan = identity(n);
  const MatrixXd P = random_covariance(n, engine);
  std::vector<double> memory(static_cast<std::size_t>(padded(n) * n), 0.0);
  Joseph joseph(plan, 3, memory.data());
  CovarianceForm& form = joseph;
  MatrixXd given = P;
  form.set({given.data(), n, n, n});
  form.inflate(2, 0.5);
  const MatrixXd T3 = random_matrix(3, 3, engine);
  form.transform(T3.data(), 1, 3);

  MatrixXd T = MatrixXd::Identity(n, n);
  T.block(1, 1, 3, 3) = T3;
  MatrixXd expected = P;
  expected(2, 2) += 0.5;
  expected = (T * expected * T.transpose()).eval();
  const MatrixXd given_back = form.expand().as();
  CHECK((given_back - expected).norm() < 1e-12 * expected.norm());
}

TEST_CASE("Phi and Qd written out give the same step as their tables, in the diagonal, mirrored and cross blocks") {
  const int n = 5;
  TransitionPlan plan;
  plan.n = n;
  plan.diagonals = {{0, 0, 0}};
  plan.groups = {RowGroup{1, 2, {{1, 1, 0}, {2, 1, 2}, {4, 1, 4}}, {}}};
  plan.noise = {{0, 0, places(1), {}, 0},
                {1, 1, places(2), places(2, 2), 1},
                {1, 3, places(2), {}, 2},
                {0, 4, places(1), places(1), 3}};
  finish(plan);
  const double diagonal[] = {0.5}, group[] = {1, 0.1, 0.2, 1, -0.3, 0.4};
  const double q0[] = {0.1}, q1[] = {0.4, 0.05, 0.05, 0.3}, q2[] = {0.02, 0.03}, q3[] = {0.01};
  const double* const phi[] = {diagonal, group};
  const double* const noise[] = {q0, q1, q2, q3};
  MatrixXd Phi(n, n), Qd(n, n);
  expand_transition(plan, phi, {Phi.data(), n, n, n});
  expand_noise(plan, noise, {Qd.data(), n, n, n});
  MatrixXd expected_Phi = MatrixXd::Identity(n, n), expected_Qd = MatrixXd::Zero(n, n);
  expected_Phi(0, 0) = 0.5;
  expected_Phi.block(1, 1, 2, 2) << 1, 0.2, 0.1, 1;
  expected_Phi.block(1, 4, 2, 1) << -0.3, 0.4;
  expected_Qd(0, 0) = 0.1;
  expected_Qd.block(1, 1, 2, 2) << 0.4, 0.05, 0.05, 0.3;
  expected_Qd(1, 3) = expected_Qd(3, 1) = 0.02;
  expected_Qd(2, 4) = expected_Qd(4, 2) = 0.03;
  expected_Qd(0, 4) = expected_Qd(4, 0) = 0.01;
  CHECK(Phi == expected_Phi);
  CHECK(Qd == expected_Qd);

  std::mt19937 engine(8);
  const MatrixXd P = random_covariance(n, engine);
  Stored stored(P);
  Joseph(plan, 1, stored.data.data()).predict(phi, noise);
  CHECK((stored.matrix() - (Phi * P * Phi.transpose() + Qd)).norm() < 1e-14 * P.norm());
}

TEST_CASE("what cannot be the covariance of noise is refused, what is symmetric but for rounding is not") {
  Eigen::Matrix3d R = Eigen::Vector3d(4, 1e-8, 0).asDiagonal();
  const auto view = [&] { return MatrixView{R.data(), 3, 3, 3}; };
  CHECK(flaw_of_noise(view()).empty());
  R(0, 1) = 1e-4;
  R(1, 0) = 1e-4 * (1 + 1e-13);
  CHECK(flaw_of_noise(view()).empty());
  R(1, 0) = -1e-4;
  CHECK(flaw_of_noise(view()) == "R(0, 1) = 0.0001 but R(1, 0) = -0.0001, which is not symmetric");
  R(1, 0) = 1e-4;
  R(2, 2) = -1e-300;
  CHECK(flaw_of_noise(view()) == "R(2, 2) = -1e-300, which is not a variance");
  R(2, 2) = std::numeric_limits<double>::infinity();
  CHECK(flaw_of_noise(view()) == "R(2, 2) = inf, which is not finite");
  R(2, 2) = 0;
  R(0, 2) = R(2, 0) = std::nan("");
  CHECK_FALSE(flaw_of_noise(view()).empty());
}

TEST_CASE("a variance that an update makes smaller than zero by rounding is zero, with its row and column") {
  std::mt19937 engine(5);
  int rounded = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + static_cast<int>(engine() % 6);
    MatrixXd H = MatrixXd::Zero(1, n);
    H(0, 0) = std::uniform_real_distribution<double>(0.1, 1)(engine);
    Stored stored(random_covariance(n, engine));
    Update update(H, MatrixXd::Constant(1, 1, 1e-40), VectorXd::Zero(1), n, 1);
    const TransitionPlan plan = identity(n);
    Joseph form(plan, n, stored.data.data());
    form.project(update.columns, update.work);
    REQUIRE_FALSE(form.factor(update.columns, update.work));
    form.gain({}, update.work);
    form.correct({}, update.work);
    REQUIRE(form.is_below(1e30));
    REQUIRE(stored.is_symmetric_to_the_bit());
    if (form.rounded().empty()) continue;
    ++rounded;
    REQUIRE(form.rounded().size() == 1);
    REQUIRE(form.rounded()[0] == 0);
    REQUIRE(stored.matrix().row(0).isZero(0));
    REQUIRE(stored.matrix().col(0).isZero(0));
    if (n > 1) REQUIRE(form.variance(1) > 0);  // of the others nothing is taken
  }
  REQUIRE(rounded > 10);
}

TEST_CASE("a variance that is further below zero stays as it is, and is found") {
  MatrixXd P(2, 2);
  P << 1, 2, 2, 1;  // no covariance
  for (const double excess : {1.0, 1e-6, 1e-11}) {
    P(1, 1) = 4 - 4 * excess;
    Stored stored(P);
    Update update(MatrixXd::Identity(1, 2), MatrixXd::Constant(1, 1, 1e-40), VectorXd::Zero(1), 2, 1);
    const TransitionPlan plan = identity(2);
    Joseph form(plan, 2, stored.data.data());
    form.project(update.columns, update.work);
    REQUIRE_FALSE(form.factor(update.columns, update.work));
    form.gain({}, update.work);
    form.correct({}, update.work);
    CHECK(form.variance(1) < 0);
    CHECK_FALSE(form.is_below(1e30));
  }
}

}  // namespace covariance_test
