// SPDX-License-Identifier: Apache-2.0
// The plugin's own tests: the sphere itself, the models as sphere.json composes them, and fifty runs.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <binnacle/parts.hpp>

#include "common/example.hpp"
#include "s2.hpp"

using namespace binnacle;
using example::is_near;
using s2::Vector2;
using s2::Vector3;

namespace {

Vector3 direction(double x, double y, double z) { return Vector3(x, y, z).normalized(); }

/// Poles, the equator, where the axes jump, on both sides of it, and anywhere.
const std::vector<Vector3> points{direction(0, 0, 1),     direction(0, 0, -1),       direction(1, 0, 0),
                                  direction(0, -1, -0.0), direction(0.6, 0.8, 1e-9), direction(0.6, 0.8, -1e-9),
                                  direction(-1, 1, 0.2),  direction(0.3, -0.5, -0.9)};
const std::vector<Vector2> errors{{0, 0},      {1e-9, -2e-9}, {5e-5, 2e-5}, {1e-3, -3e-3},
                                  {0.02, 0.3}, {-1.5, 0.8},   {2, 1.5}};

/// ∂f/∂δ at δ = 0 by central differences, extrapolated (Richardson).
template <int Columns, class Function>
auto differences(const Function& f, double h = 1e-3) {
  Eigen::Matrix<double, decltype(f(Eigen::Matrix<double, Columns, 1>()))::RowsAtCompileTime, Columns> J;
  for (int j = 0; j < Columns; ++j) {
    const auto central = [&](double step) {
      const Eigen::Matrix<double, Columns, 1> delta = step * Eigen::Matrix<double, Columns, 1>::Unit(j);
      return ((f(delta) - f(-delta)) / (2 * step)).eval();
    };
    J.col(j) = (4 * central(h / 2) - central(h)) / 3;
  }
  return J;
}

struct Turned {
  Vector3 x;
  Eigen::Matrix2d Phi_xx, Q;
  Eigen::Matrix<double, 2, 3> Phi_xb;
};

/// One step of the process model over samples of 0.1 s each.
Turned turn(const ProcessModel& model, const Vector3& x, const Vector3& bias, const std::vector<Vector3>& rates,
            bool is_linearized = true) {
  constexpr Time interval = 100'000'000;
  std::vector<InputSample> samples;
  Step step{0, 0, 0, {}};
  for (const Vector3& rate : rates) {
    samples.push_back({step.t1, step.t1 + interval, 0.1, step.t1, step.t1 + interval, rate.data()});
    step.t1 += interval, step.dt += 0.1;
  }
  step.samples = samples;

  Turned turned;
  const double* const from[] = {x.data(), bias.data()};
  double* const to[] = {turned.x.data(), nullptr};
  REQUIRE(model.declaration().transition.size() == 2);
  REQUIRE(model.declaration().transition[0].from == 0);
  double* const phi[] = {turned.Phi_xx.data(), turned.Phi_xb.data()};
  double* const q[] = {turned.Q.data()};
  ProcessInput in;
  in.step = step;
  in.x = from;
  ProcessOutput out;
  out.x = to;
  if (is_linearized) out.phi = phi, out.Qd = q;
  const Result result = model.propagate(in, out);
  INFO(result.reason);
  REQUIRE(result);
  return turned;
}

struct Sighted {
  Result result;
  Vector2 residual;
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero(), R = Eigen::Matrix2d::Zero();
};

Sighted sight(const MeasurementModel& model, const Vector3& z, const Vector3& x, bool is_linearized = true) {
  Sighted sighted;
  const double* const values[] = {x.data()};
  const MatrixView H[] = {{sighted.H.data(), 2, 2, 2}};
  std::array<std::int64_t, 2> keys{};
  MeasurementInput in;
  in.sample.fields = z.data();
  in.x = values;
  MeasurementOutput out;
  out.residual = {sighted.residual.data(), 2};
  if (is_linearized) out.H = H;
  out.R = {sighted.R.data(), 2, 2, 2};
  out.row_keys = keys;
  sighted.result = model.linearize(in, out);
  return sighted;
}

const std::vector<Vector3> tumble{{0.5, -1, 2}, {3, 0.2, -0.4}, {0, 0, 0}};

}  // namespace

TEST_CASE("the axes are orthonormal and touch the sphere everywhere") {
  for (const Vector3& x : points) {
    const auto B = s2::basis(x);
    CHECK((B.transpose() * B).isIdentity(1e-14));
    CHECK((B.transpose() * x).norm() < 1e-14);
  }
}

TEST_CASE("plus and minus undo each other, along great circles") {
  for (const Vector3& x : points)
    for (const Vector2& delta : errors) {
      INFO(x.transpose() << " by " << delta.transpose());
      const Vector3 y = s2::plus(x, delta);
      CHECK(std::abs(y.norm() - 1) < 1e-15);
      CHECK((s2::minus(y, x) - delta).norm() < 1e-13);
      CHECK(is_near(std::atan2(x.cross(y).norm(), x.dot(y)), delta.norm(), 0, 1e-15));
    }
}

TEST_CASE("the derivatives of plus and minus, and the reset, are those of differences") {
  for (const Vector3& x : points)
    for (const Vector2& delta : errors) {
      INFO(x.transpose() << " by " << delta.transpose());
      const Vector3 y = s2::plus(x, delta);
      const auto D = differences<2>([&](const Vector2& e) { return s2::plus(x, delta + e); });
      CHECK((D - s2::plus_jacobian(x, delta)).cwiseAbs().maxCoeff() < 1e-9);
      const auto G = differences<2>([&](const Vector2& e) { return s2::minus(s2::plus(x, delta + e), y); });
      CHECK((G - s2::reset_jacobian(x, delta)).cwiseAbs().maxCoeff() < 1e-9);
      const auto M = differences<2>([&](const Vector2& e) { return s2::minus(s2::plus(y, e), x); });
      CHECK((M - s2::minus_jacobian(y, x)).cwiseAbs().maxCoeff() < 1e-7);
    }
}

TEST_CASE("the reset Jacobian of the block is that of the sphere") {
  const auto down = parts::block(*example::compose(), "body", "down");
  for (const Vector3& x : points)
    for (const Vector2& delta : errors) {
      Eigen::Matrix2d G;
      REQUIRE(down.block->reset_jacobian(x.data(), delta.data(), G.data()));
      CHECK(G == s2::reset_jacobian(x, delta));
    }
}

TEST_CASE("a direction is read as it was written, and nothing else is taken for one") {
  const auto down = parts::block(*example::compose(), "body", "down");
  const Vector3 v = 1.005 * direction(1, 2, -3);
  Vector3 x, again;
  REQUIRE(down.block->write(v.data(), x.data()));
  CHECK((x - direction(1, 2, -3)).norm() < 1e-15);
  down.block->read(x.data(), again.data());
  CHECK(again == x);
  const Vector3 zero = Vector3::Zero(), twice = 2 * x;
  CHECK_FALSE(down.block->write(zero.data(), again.data()));
  CHECK_FALSE(down.block->write(twice.data(), again.data()));
}

TEST_CASE("in axes that turn to the right a fixed direction goes to the left") {
  const auto part = parts::process(*example::compose(), "body", "turning");
  const Vector3 x(1, 0, 0), bias(0, 0, 0.1);
  // 0.1 s at 1.1 rad/s about z, of which 0.1 are bias: a tenth of a radian.
  const Turned turned = turn(*part.model, x, bias, {Vector3(0, 0, 1.1)});
  CHECK((turned.x - Vector3(std::cos(0.1), -std::sin(0.1), 0)).norm() < 1e-15);
  const double q = 0.1 * std::numbers::pi / 180;  // of sphere.json
  CHECK((turned.Q / (q * q * 0.1)).isIdentity(1e-12));
}

TEST_CASE("Phi is the derivative of a step on the sphere") {
  const auto part = parts::process(*example::compose(), "body", "turning");
  const Vector3 bias(0.1, -0.2, 0.05);
  for (const Vector3& x : points) {
    INFO(x.transpose());
    const Turned turned = turn(*part.model, x, bias, tumble);
    const auto xx = differences<2>(
        [&](const Vector2& e) { return s2::minus(turn(*part.model, s2::plus(x, e), bias, tumble).x, turned.x); });
    CHECK((xx - turned.Phi_xx).cwiseAbs().maxCoeff() < 1e-9);
    const auto xb =
        differences<3>([&](const Vector3& e) { return s2::minus(turn(*part.model, x, bias + e, tumble).x, turned.x); });
    CHECK((xb - turned.Phi_xb).cwiseAbs().maxCoeff() < 1e-9);
    CHECK(turn(*part.model, x, bias, tumble, false).x == turned.x);  // to the bit without Jacobians
  }
}

TEST_CASE("H is the derivative of what is seen, however far from the estimate") {
  const auto part = parts::measurement(*example::compose(), "body", "seen");
  for (const Vector3& x : points)
    for (const Vector2& delta : errors) {
      if (delta.norm() > 2) continue;
      const Vector3 z = 9.8 * s2::plus(x, delta);  // of any length
      INFO(x.transpose() << " seen at " << z.transpose());
      const Sighted sighted = sight(*part.model, z, x);
      REQUIRE(sighted.result);
      CHECK(is_near(sighted.residual.norm(), delta.norm(), 0, 1e-14));
      const auto H = differences<2>([&](const Vector2& e) { return -sight(*part.model, z, s2::plus(x, e)).residual; });
      CHECK((H - sighted.H).cwiseAbs().maxCoeff() < 1e-8);
      CHECK(sight(*part.model, z, x, false).residual == sighted.residual);
    }
  CHECK_FALSE(sight(*part.model, Vector3(-1, 0.1, 0), Vector3(1, 0, 0)).result);
  CHECK_FALSE(sight(*part.model, Vector3::Zero(), Vector3(1, 0, 0)).result);
}

TEST_CASE("an update by a perfect sighting ends where it points") {
  const auto part = parts::measurement(*example::compose(), "body", "seen");
  for (const Vector3& x : points) {
    const Vector3 z = s2::plus(x, {0.01, -0.02});
    const Sighted sighted = sight(*part.model, z, x);
    const Vector2 delta = sighted.H.inverse() * sighted.residual;  // K r without noise
    CHECK((s2::plus(x, delta) - z).norm() < 1e-5);
  }
}

TEST_CASE("errors of fifty runs of a tumbling body are as large as the filter believes") {
  const auto figures = example::study();
  for (const auto& [metric, dof] : std::map<std::string, double>{{"body/down/nees", 2}, {"body/gyro_bias/nees", 3}}) {
    const auto& figure = figures.at(metric);
    INFO(metric << " " << figure.mean << " in " << figure.runs << " runs");
    CHECK(figure.runs == 50);
    CHECK(std::abs(figure.mean - dof) < 2.58 * std::sqrt(2 * dof / figure.runs));  // 99 %
  }
  CHECK(std::abs(figures.at("body/seen/nis").mean - 2) < 2.58 * std::sqrt(2 * 2 / (50 * 120.0)));
  CHECK(figures.at("body/down.angle/rms").mean < 1.0);        // deg
  CHECK(figures.at("body/gyro_bias.norm/final").mean < 0.2);  // deg/s, of 0.5 at the start
}
