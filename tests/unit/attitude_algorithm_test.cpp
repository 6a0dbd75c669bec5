// SPDX-License-Identifier: Apache-2.0
// plugins/common/attitude: coefficients against the Bortz equation, error constants of paper 002, quaternions.
#include "catch.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <boost/multiprecision/eigen.hpp>

#include "../coning_drift.hpp"
#include "attitude/algorithm.hpp"
#include "attitude/interval_weights.hpp"
#include "attitude/quaternion.hpp"
#include "attitude/rotation_vector.hpp"

namespace attitude_algorithm_test {

using namespace binnacle::attitude;
using binnacle::test::lag_expression;
using binnacle::test::Real;
using Eigen::Vector3d;

namespace {

/// x(t) = Σ c_k t^k and its integral, on [0, 1].
struct PolynomialRate {
  std::vector<Vector3d> c;

  Vector3d at(double t) const {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = c.size(); k-- > 0;) sum = sum * t + c[k];
    return sum;
  }
  Vector3d integral(double from, double to) const {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < c.size(); ++k) {
      const double n = static_cast<double>(k + 1);
      sum += c[k] * ((std::pow(to, n) - std::pow(from, n)) / n);
    }
    return sum;
  }
  PolynomialRate times(double factor) const {
    PolynomialRate scaled = *this;
    for (Vector3d& v : scaled.c) v *= factor;
    return scaled;
  }
};

PolynomialRate random_rate(int degree, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  PolynomialRate rate;
  for (int k = 0; k <= degree; ++k) rate.c.push_back(Vector3d::NullaryExpr([&] { return uniform(random); }));
  return rate;
}

/// What a body with these rates has done after [0, 1]: rotation vector (Bortz, paper 002 (1)), ∫C f dt, ∫(1 − t) C f dt.
struct Motion {
  Vector3d phi = Vector3d::Zero(), u = Vector3d::Zero(), s = Vector3d::Zero();
};
Motion integrated(const PolynomialRate& omega, const PolynomialRate& f) {
  const auto slope = [&](double t, const Motion& m) {
    const Vector3d w = omega.at(t), once = m.phi.cross(w);
    const double angle = m.phi.norm();
    const Eigen::Matrix3d C =
        Eigen::AngleAxisd(angle, angle > 0 ? Vector3d(m.phi / angle) : Vector3d::UnitX()).toRotationMatrix();
    return Motion{w + 0.5 * once + m.phi.cross(once) / 12.0, C * f.at(t), m.u};
  };
  const auto moved = [](const Motion& m, const Motion& d, double h) {
    return Motion{m.phi + h * d.phi, m.u + h * d.u, m.s + h * d.s};
  };
  Motion m;
  constexpr int steps = 400;
  const double h = 1.0 / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const Motion a = slope(t, m), b = slope(t + h / 2, moved(m, a, h / 2)), c = slope(t + h / 2, moved(m, b, h / 2)),
                 d = slope(t + h, moved(m, c, h));
    for (const auto& [k, w] : {std::pair(&a, 1.0), std::pair(&b, 2.0), std::pair(&c, 2.0), std::pair(&d, 1.0)})
      m = moved(m, *k, w * h / 6);
  }
  return m;
}

/// The part of second order: the mean of a motion and of its reverse. What is left of higher order is 1e-8 of it.
Motion second_order(const PolynomialRate& omega, const PolynomialRate& f) {
  constexpr double small = 1e-3;
  const Motion plus = integrated(omega.times(small), f.times(small));
  const Motion minus = integrated(omega.times(-small), f.times(-small));
  const double per = 0.5 / (small * small);
  return {(plus.phi + minus.phi) * per, (plus.u + minus.u) * per, (plus.s + minus.s) * per};
}

struct Increments {
  std::vector<Vector3d> theta, dv;
  Vector3d sum_theta = Vector3d::Zero(), sum_dv = Vector3d::Zero();

  Increments(const PolynomialRate& omega, const PolynomialRate& f, const std::vector<double>& lengths) {
    double t = 0;
    for (const double length : lengths) {
      theta.push_back(omega.integral(t, t + length));
      dv.push_back(f.integral(t, t + length));
      sum_theta += theta.back(), sum_dv += dv.back();
      t += length;
    }
  }
};

std::vector<double> equal_lengths(int samples) {
  return std::vector<double>(static_cast<std::size_t>(samples), 1.0 / samples);
}

/// Relative to its size.
double off(const Vector3d& is, const Vector3d& should) { return (is - should).norm() / should.norm(); }

}  // namespace

TEST_CASE("error constants by the lag expression are 960, 204120, 82575360, and the paper's 725760 is wrong",
          "[attitude]") {
  // e(x) = −x^p/K (1 + O(x²))
  const Real x = Real(1) / 1000;
  const auto constant = [&](int samples, int power) {
    return static_cast<double>(pow(x, power) / abs(lag_expression(samples, x)));
  };
  CHECK(std::abs(constant(2, 5) / 960 - 1) < 1e-3);
  CHECK(std::abs(constant(3, 7) / 204120 - 1) < 1e-3);
  CHECK(std::abs(constant(4, 9) / 82575360 - 1) < 1e-3);
  CHECK(constant(4, 9) / 725760 > 100);
}

TEST_CASE("the library's own update has these constants, on a tiny cone in fifty digits", "[attitude]") {
  using Vector = Vector3<Real>;
  const Real cone = Real(1) / 1000000000000, x = Real(1) / 1000;
  for (const auto& [samples, power, expected] : {std::tuple(2, 5, 960.0), {3, 7, 204120.0}, {4, 9, 82575360.0}}) {
    std::vector<Vector> theta;
    const Real lag = x / samples, swing = 2 * sin(cone) * sin(lag / 2), half = sin(cone / 2);
    for (int i = 0; i < samples; ++i) {
      const Real middle = (i + Real(1) / 2) * lag;
      theta.push_back(Vector(-2 * half * half * lag, -swing * sin(middle), swing * cos(middle)));
    }
    const Vector phi = rotation_vector<Real>(theta, pair_weights<Real>(samples, Form::coning));
    // True minus computed, q ⊗ q̂*: its x component, the secular one.
    const Vector4<Real> computed = quaternion<Real>(phi);
    const Vector4<Real> back{computed[0], -computed[1], -computed[2], -computed[3]};
    const Real wide = sin(cone) * sin(x / 2);
    const Vector4<Real> exact{1 - 2 * half * half * sin(x / 2) * sin(x / 2), -half * half * sin(x), -wide * sin(x / 2),
                              wide * cos(x / 2)};
    const Real error = 2 * product<Real>(exact, back)[1] / (cone * cone);
    INFO(samples << " samples: " << static_cast<double>(pow(x, power) / error));
    CHECK(std::abs(static_cast<double>(pow(x, power) / abs(error)) / expected - 1) < 1e-3);
    CHECK(error > 0);
    CHECK(abs(error + lag_expression(samples, x)) < abs(error) / 1000);
  }
}

TEST_CASE("polynomial forms are exact to second order for rates of their degree, the Bortz equation says",
          "[attitude]") {
  std::mt19937 random(1);
  for (int samples = 1; samples <= most_samples; ++samples)
    for (int trial = 0; trial < 5; ++trial) {
      const auto omega = random_rate(samples - 1, random), f = random_rate(samples - 1, random);
      const Motion exact = second_order(omega, f);
      const Increments in(omega, f, equal_lengths(samples));
      const auto weights = pair_weights<double>(samples, Form::polynomial);
      INFO(samples << " samples");
      const Vector3d phi = rotation_vector<double>(in.theta, weights) - in.sum_theta;
      const Vector3d u = 0.5 * in.sum_theta.cross(in.sum_dv) + sculling<double>(in.theta, in.dv, weights);
      if (samples > 1) CHECK(off(phi, exact.phi) < 1e-6);
      if (samples == 1) CHECK(exact.phi.norm() < 1e-9);
      CHECK(off(u, exact.u) < 1e-6);
      if (samples < 3) continue;
      // The coning form is another thing.
      const Vector3d coning =
          rotation_vector<double>(in.theta, pair_weights<double>(samples, Form::coning)) - in.sum_theta;
      CHECK(off(coning, exact.phi) > 1e-4);
    }
}

TEST_CASE("coning and polynomial lag sums agree where the rate changes linearly", "[attitude]") {
  std::mt19937 random(2);
  for (int samples = 2; samples <= most_samples; ++samples) {
    const auto omega = random_rate(1, random), f = random_rate(1, random);
    const Motion exact = second_order(omega, f);
    const Increments in(omega, f, equal_lengths(samples));
    const auto weights = pair_weights<double>(samples, Form::coning);
    CHECK(off(rotation_vector<double>(in.theta, weights) - in.sum_theta, exact.phi) < 1e-6);
    CHECK(off(0.5 * in.sum_theta.cross(in.sum_dv) + sculling<double>(in.theta, in.dv, weights), exact.u) < 1e-6);
  }
}

TEST_CASE("the printed equation 5 is wrong, and by how much", "[attitude]") {
  std::mt19937 random(3);
  // The rate that changes linearly it gets right to its three digits. One that changes as the paper says, it does not.
  for (const auto& [degree, least, most] : {std::tuple(1, 1e-5, 1e-3), {3, 1e-2, 1.0}}) {
    const auto omega = random_rate(degree, random);
    const Motion exact = second_order(omega, omega);
    const Increments in(omega, omega, equal_lengths(4));
    const double wrong = off(printed_equation_5<double>(in.theta) - in.sum_theta, exact.phi);
    INFO("degree " << degree << ": off by " << wrong);
    CHECK(wrong > least);
    CHECK(wrong < most);
  }
  // On a coning motion it is not even as good as three samples.
  using Vector = Vector3<Real>;
  for (const double x : {0.1, 0.5, 1.0, 2.0}) {
    const Real lag = Real(x) / 4, cone = Real(1) / 1000000000000;
    std::vector<Vector> theta;
    for (int i = 0; i < 4; ++i) {
      const Real middle = (i + Real(1) / 2) * lag, swing = 2 * sin(cone) * sin(lag / 2);
      theta.push_back(Vector(0, -swing * sin(middle), swing * cos(middle)));
    }
    const Real error = (sin(Real(x)) - Real(x)) / 2 + printed_equation_5<Real>(theta)[0] / (cone * cone);
    INFO("W h = " << x << ": " << static_cast<double>(error));
    CHECK(abs(error) > 10 * abs(lag_expression(3, x)));
  }
}

TEST_CASE("weights for equal intervals are the rational ones", "[attitude]") {
  for (int samples = 1; samples <= most_samples; ++samples) {
    const auto w = interval_weights(equal_lengths(samples));
    const auto rational = pair_weights<double>(samples, Form::polynomial);
    for (int i = 0; i < most_samples; ++i)
      for (int j = 0; j < most_samples; ++j) CHECK(std::abs(w.pairs.k[i][j] - rational.k[i][j]) < 1e-14);
  }
  // Of ∫ v dt: Simpson, three eighths, Boole, in terms of increments instead of values.
  const auto two = interval_weights(equal_lengths(2)), four = interval_weights(equal_lengths(4));
  CHECK(std::abs(two.position[0] - 5.0 / 6) < 1e-15);
  CHECK(std::abs(two.position[1] - 1.0 / 6) < 1e-15);
  CHECK(std::abs(four.position[3] - 7.0 / 90) < 1e-15);
}

TEST_CASE("weights for unequal intervals are exact for rates of their degree", "[attitude]") {
  std::mt19937 random(4);
  const std::vector<std::vector<double>> cuts = {{1}, {0.3, 0.7}, {0.5, 0.2, 0.3}, {0.1, 0.4, 0.2, 0.3}};
  for (const auto& lengths : cuts) {
    const int samples = static_cast<int>(lengths.size());
    const auto omega = random_rate(samples - 1, random), f = random_rate(samples - 1, random);
    const Motion exact = second_order(omega, f);
    const Increments in(omega, f, lengths);
    const auto w = interval_weights(lengths);
    INFO(samples << " samples");
    if (samples > 1) CHECK(off(rotation_vector<double>(in.theta, w.pairs) - in.sum_theta, exact.phi) < 1e-6);
    CHECK(off(0.5 * in.sum_theta.cross(in.sum_dv) + sculling<double>(in.theta, in.dv, w.pairs), exact.u) < 1e-6);
    Vector3d first = Vector3d::Zero(), second = Vector3d::Zero();
    for (std::size_t j = 0; j < lengths.size(); ++j) {
      first += w.position[j] * in.dv[j];
      for (std::size_t i = 0; i < lengths.size(); ++i) second += w.turned[i][j] * in.theta[i].cross(in.dv[j]);
    }
    CHECK(off(second, exact.s) < 1e-6);
    // ∫ (1 − t) f dt of a polynomial: by parts the integral of what has been gained.
    Vector3d gained = Vector3d::Zero();
    for (std::size_t k = 0; k < f.c.size(); ++k)
      gained += f.c[k] / (static_cast<double>(k + 1) * static_cast<double>(k + 2));
    CHECK(off(first, gained) < 1e-12);
  }
  CHECK(are_equal(std::array{0.013333333, 0.013333334, 0.013333333}));
  CHECK_FALSE(are_equal(std::array{0.01, 0.0101}));
}

TEST_CASE("quaternions: exact to the last digits, and truncated where that is asked for", "[attitude]") {
  const Vector3d axis = Vector3d(1, -2, 0.5).normalized();
  for (const double angle : {0.0, 1e-9, 1e-3, 0.3, 0.499, 0.501, 2.0, 3.1}) {
    const Vector3<Real> phi = (axis * angle).cast<Real>();
    const auto exact = quaternion<Real>(phi);
    const auto q = quaternion<double>(axis * angle);
    const auto single = quaternion<float>((axis * angle).cast<float>());
    const auto extended = quaternion<long double>((axis * angle).cast<long double>());
    for (int i = 0; i < 4; ++i) {
      CHECK(std::abs(static_cast<double>(exact[i] - q[i])) < 2e-16);
      CHECK(std::abs(static_cast<double>(exact[i]) - static_cast<double>(single[i])) < 2e-7);
      CHECK(static_cast<double>(abs(exact[i] - Real(extended[i]))) < 1e-18);
    }
  }
  const double a = 0.4;
  const Vector3d phi = axis * a;
  const auto check = [&](Truncation truncation, double cosine, double sine) {
    const auto q = quaternion<double>(phi, truncation);
    CHECK(std::abs(q[0] - cosine) < 1e-16);
    CHECK(off(q.tail<3>(), axis * sine) < 1e-15);
  };
  const double h = a / 2, h2 = h * h;
  check(Truncation::at_power(2), 1 - h2 / 2, h);
  check(Truncation::at_power(4), 1 - h2 / 2 + h2 * h2 / 24, h - h * h2 / 6);
  check(Truncation::at_power(5), 1 - h2 / 2 + h2 * h2 / 24, h - h * h2 / 6 + h * h2 * h2 / 120);
  check(Truncation::after_terms(2), 1 - h2 / 2, h - h * h2 / 6);
  check(Truncation::after_terms(4), 1 - h2 / 2 + h2 * h2 / 24 - h2 * h2 * h2 / 720,
        h - h * h2 / 6 + h * h2 * h2 / 120 - h * h2 * h2 * h2 / 5040);
}

TEST_CASE("an update turns the body by phi and the axes by what they turned", "[attitude]") {
  const Eigen::Vector4d q = Eigen::Vector4d(0.5, -0.3, 0.7, 0.4).normalized();
  const Vector3d phi(0.02, -0.01, 0.03), frame(0.001, 0.002, -0.003);
  const auto matrix = [](const Eigen::Vector4d& p) {
    return Eigen::Quaterniond(p[0], p[1], p[2], p[3]).toRotationMatrix();
  };
  const auto turn = [](const Vector3d& v) { return Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix(); };
  const Update exact, single{Precision::float_, {}};
  CHECK((matrix(exact(q, phi)) - matrix(q) * turn(phi)).norm() < 1e-15);
  CHECK((matrix(exact(frame, q, phi)) - turn(-frame) * matrix(q) * turn(phi)).norm() < 1e-15);
  const double rough = (matrix(single(frame, q, phi)) - turn(-frame) * matrix(q) * turn(phi)).norm();
  CHECK(rough < 1e-6);
  CHECK(rough > 1e-9);
}

TEST_CASE("fewer samples than chosen go by the weights for so many, unequal ones by polynomials", "[attitude]") {
  Algorithm::Choice choice;
  choice.samples = 4;
  const Algorithm four(choice);
  IntervalWeights storage;
  CHECK(four.weights(equal_lengths(2), storage).pairs.k[0][1] == 2.0 / 3);
  CHECK(four.weights(equal_lengths(4), storage).pairs.k[0][1] == -92.0 / 105);
  const std::array uneven = {0.01, 0.02, 0.01, 0.01};
  CHECK(&four.weights(uneven, storage) == &storage);
  CHECK(storage.pairs.k[0][1] == interval_weights(uneven).pairs.k[0][1]);
  choice.update.precision = Precision::float_;
  const Algorithm single(choice);
  const std::array<Vector3d, 4> theta = {Vector3d(0.01, 0.02, 0.03), Vector3d(-0.01, 0.02, 0), Vector3d(0.1, 0.2, 0.3),
                                         Vector3d(0.3, 0.1, 0)};
  for (const auto& lengths : {std::array{1.0, 1.0, 1.0, 1.0}, uneven}) {
    const Vector3d in_double = four.rotation(theta, four.weights(lengths, storage));
    const Vector3d in_float = single.rotation(theta, single.weights(lengths, storage));
    CHECK(off(in_float, in_double) < 1e-6);
    CHECK(in_float == in_float.cast<float>().cast<double>());
    CHECK(in_float != in_double);
  }
}

}  // namespace attitude_algorithm_test
