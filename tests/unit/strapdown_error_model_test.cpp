// SPDX-License-Identifier: Apache-2.0
// strapdown/error_model.hpp against differences of the nonlinear mechanization, and its noise against integration.
#include "catch.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "strapdown/earth.hpp"
#include "strapdown/error_model.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace strapdown_error_model_test {

using namespace binnacle::strapdown;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

// Error state of the tests: p, v, phi, gyro bias and scale, accelerometer bias and scale; three components each.
enum Block { P, V, PHI, BG, SG, BA, SA };
constexpr int blocks = 7, size = 3 * blocks;
const std::array<std::string, blocks> names = {"p", "v", "phi", "bg", "sg", "ba", "sa"};
using Error = Eigen::Matrix<double, size, 1>;
using Phi = Eigen::Matrix<double, size, size>;

struct State {
  Navigation nav;
  SensorErrors sensor;
};

State plus(const State& x, const Error& d) {
  State y = x;
  y.nav.lla = position_plus(x.nav.lla, d.segment<3>(3 * P));
  y.nav.v_n += d.segment<3>(3 * V);
  y.nav.q_nb = attitude_plus(x.nav.q_nb, d.segment<3>(3 * PHI));
  y.sensor.gyro_bias += d.segment<3>(3 * BG);
  y.sensor.gyro_scale += d.segment<3>(3 * SG);
  y.sensor.accel_bias += d.segment<3>(3 * BA);
  y.sensor.accel_scale += d.segment<3>(3 * SA);
  return y;
}

Error minus(const State& a, const State& b) {
  Error d;
  d << position_minus(a.nav.lla, b.nav.lla), a.nav.v_n - b.nav.v_n, attitude_minus(a.nav.q_nb, b.nav.q_nb),
      a.sensor.gyro_bias - b.sensor.gyro_bias, a.sensor.gyro_scale - b.sensor.gyro_scale,
      a.sensor.accel_bias - b.sensor.accel_bias, a.sensor.accel_scale - b.sensor.accel_scale;
  return d;
}

/// Measured increments, the first of them before the start (the coning term's neighbour).
using Measured = std::vector<Increment>;

State propagated(const State& x, const Measured& measured) {
  State y = x;
  Previous previous = remember({}, correct(measured.front(), x.sensor));
  for (std::size_t i = 1; i < measured.size(); ++i) {
    const Increment increment = correct(measured[i], x.sensor);
    y.nav = advance(y.nav, increment, previous);
    previous = remember(previous, increment);
  }
  return y;
}

/// Central differences with one step of Richardson's extrapolation: the error goes with the fourth power of the step.
Phi differences(const State& x, const Measured& measured, const std::array<double, blocks>& step) {
  const State centre = propagated(x, measured);
  Phi phi;
  for (int j = 0; j < size; ++j) {
    const auto slope = [&](double s) -> Error {
      const Error d = s * Error::Unit(j);
      return (minus(propagated(plus(x, d), measured), centre) - minus(propagated(plus(x, -d), measured), centre)) /
             (2 * s);
    };
    const double s = step[static_cast<std::size_t>(j / 3)];
    phi.col(j) = (4.0 * slope(s / 2) - slope(s)) / 3.0;
  }
  return phi;
}

Phi assembled(const TransitionBlocks& t) {
  Phi phi = Phi::Identity();
  const auto put = [&](Block row, Block column, const Matrix3d& m) { phi.block<3, 3>(3 * row, 3 * column) = m; };
  put(P, P, t.p_p), put(P, V, t.p_v), put(P, PHI, t.p_phi), put(P, BA, t.p_ba), put(P, SA, t.p_sa);
  put(V, P, t.v_p), put(V, V, t.v_v), put(V, PHI, t.v_phi), put(V, BG, t.v_bg), put(V, SG, t.v_sg);
  put(V, BA, t.v_ba), put(V, SA, t.v_sa);
  put(PHI, P, t.phi_p), put(PHI, V, t.phi_v), put(PHI, PHI, t.phi_phi), put(PHI, BG, t.phi_bg);
  put(PHI, SG, t.phi_sg), put(PHI, BA, t.phi_ba), put(PHI, SA, t.phi_sa);
  return phi;
}

Phi modelled(const State& x, const Measured& two, Order order) {
  const Increment increment = correct(two.back(), x.sensor);
  const Step s = step(x.nav, increment, remember({}, correct(two.front(), x.sensor)));
  return assembled(transition(s.mid, input_sensitivity(increment, x.sensor), order));
}

struct Scenario {
  std::string name;
  State x;
  Vector3d omega, f, omega_slope, f_slope;

  Measured measured(double dt) const {
    const auto over = [&](double from, double to) {
      const double length = to - from, square = 0.5 * (to * to - from * from);
      return Increment{length, omega * length + omega_slope * square, f * length + f_slope * square};
    };
    return {over(-dt, 0.0), over(0.0, dt)};
  }
};

std::vector<Scenario> scenarios() {
  SensorErrors none, some;
  some.gyro_bias = {0.01, -0.02, 0.015};
  some.gyro_scale = {0.01, -0.02, 0.005};
  some.accel_bias = {0.1, -0.2, 0.15};
  some.accel_scale = {-0.01, 0.02, 0.03};
  const auto nav = [](double lat, double lon, double height, Vector3d v, Vector3d rpy) {
    return Navigation{{lat * degree, lon * degree, height}, v, quaternion_from_euler(rpy * degree)};
  };
  return {
      {"car",
       {nav(37, 127, 100, {12, -9, 0.3}, {2, -4, 140}), none},
       {0.02, -0.05, 0.3},
       {1.5, -2, -9.9},
       {0.1, 0, 0.2},
       {1, 2, -1}},
      {"fast aircraft",
       {nav(48, 11, 11000, {-210, 220, -15}, {35, 8, -60}), some},
       {0.2, 0.1, -0.1},
       {3, 1, -14},
       {-0.1, 0.3, 0.1},
       {0, 3, 2}},
      {"far north",
       {nav(75, -30, 9000, {180, 240, 20}, {-20, 15, 80}), some},
       {-0.1, 0.2, 0.15},
       {-2, 3, -8},
       {0.2, 0.1, 0},
       {1, 0, 1}},
      {"far south",
       {nav(-68, 179.99, 500, {-60, 90, -40}, {10, -50, 170}), none},
       {0.3, -0.1, 0.1},
       {6, 2, -7},
       {0, 0, 0.3},
       {-2, 1, 0}},
      {"vertical",
       {nav(-33, 151, 30, {3, 5, -2}, {0, 89, 10}), none},
       {0.1, 0.1, 0.1},
       {9.5, 0.5, 0.4},
       {0.1, 0, 0.1},
       {0, 0, 1}},
      {"at rest",
       {nav(37, 127, 20, {0, 0, 0}, {1, 2, 3}), none},
       {5e-5, 0, -4e-5},
       {0.3, -0.2, -9.79},
       {0, 0, 0},
       {0, 0, 0}},
  };
}

constexpr std::array<double, blocks> difference_step = {2000.0, 10.0, 0.01, 0.02, 0.005, 1.0, 0.005};

/// What roundoff leaves in a difference quotient: nanometres of latitude and longitude, ulps of velocity and attitude.
double roundoff(int row, int column) {
  static constexpr std::array<double, blocks> of_row = {8e-9, 3e-13, 3e-15, 1e-16, 1e-16, 1e-15, 1e-16};
  return of_row[static_cast<std::size_t>(row)] / difference_step[static_cast<std::size_t>(column)];
}

double largest(const Phi& m, int row, int column) { return m.block<3, 3>(3 * row, 3 * column).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("correcting increments and its derivatives", "[strapdown][error]") {
  for (const Scenario& s : scenarios()) {
    const Increment measured = s.measured(0.01).back();
    const SensorErrors e = s.x.sensor;
    const Increment c = correct(measured, e);
    // measured = (1 + scale) true + bias
    REQUIRE((c.dtheta.cwiseProduct(Vector3d::Ones() + e.gyro_scale) + e.gyro_bias * c.dt - measured.dtheta).norm() <
            1e-16);
    REQUIRE((c.dv.cwiseProduct(Vector3d::Ones() + e.accel_scale) + e.accel_bias * c.dt - measured.dv).norm() < 1e-15);
    const InputSensitivity d = input_sensitivity(c, e);
    for (int i = 0; i < 3; ++i) {
      const auto slope = [&](Vector3d SensorErrors::*member, Vector3d Increment::*of) {
        SensorErrors up = e, down = e;
        (up.*member)[i] += 1e-4;
        (down.*member)[i] -= 1e-4;
        return ((correct(measured, up).*of)[i] - (correct(measured, down).*of)[i]) / 2e-4;
      };
      REQUIRE(std::abs(slope(&SensorErrors::gyro_bias, &Increment::dtheta) - d.gyro_bias[i]) < 1e-9);
      REQUIRE(std::abs(slope(&SensorErrors::gyro_scale, &Increment::dtheta) - d.gyro_scale[i]) < 1e-9);
      REQUIRE(std::abs(slope(&SensorErrors::accel_bias, &Increment::dv) - d.accel_bias[i]) < 1e-8);
      REQUIRE(std::abs(slope(&SensorErrors::accel_scale, &Increment::dv) - d.accel_scale[i]) < 1e-8);
    }
  }
  Increment cut{0.002, {0, 0, 0}, {0, 0, 0}, 0.005, 0.003};
  REQUIRE(correct(cut, {}).sample_dt == 0.005);
  REQUIRE(correct(cut, {}).sample_offset == 0.003);
}

TEST_CASE("every transition block against differences, and errors fall as dt^2 and dt^3", "[strapdown][error]") {
  for (const Scenario& s : scenarios()) {
    for (Order order : {Order::first, Order::second}) {
      const std::array<double, 3> intervals = {0.2, 0.1, 0.05};
      std::array<Phi, 3> truth, error;
      for (std::size_t k = 0; k < intervals.size(); ++k) {
        truth[k] = differences(s.x, s.measured(intervals[k]), difference_step);
        error[k] = modelled(s.x, s.measured(intervals[k]), order) - truth[k];
      }
      const double power = order == Order::first ? 2.0 : 3.0;
      for (int row = P; row <= PHI; ++row) {
        for (int column = P; column <= SA; ++column) {
          for (std::size_t k = 1; k < intervals.size(); ++k) {
            const double before = largest(error[k - 1], row, column), now = largest(error[k], row, column);
            CAPTURE(s.name, names[static_cast<std::size_t>(row)], names[static_cast<std::size_t>(column)], power,
                    intervals[k], before, now, largest(truth[k], row, column), roundoff(row, column));
            REQUIRE(now < before / std::pow(2.0, power - 0.25) + roundoff(row, column) +
                              5e-10 * largest(truth[k], row, column));
          }
        }
      }
    }
  }
}

TEST_CASE("at 100 Hz the second order is right to parts per million where it matters", "[strapdown][error]") {
  for (const Scenario& s : scenarios()) {
    const Phi truth = differences(s.x, s.measured(0.01), difference_step);
    const Phi error = modelled(s.x, s.measured(0.01), Order::second) - truth;
    const std::array<std::array<int, 2>, 8> leading = {
        {{P, V}, {V, PHI}, {V, BA}, {PHI, BG}, {V, P}, {PHI, P}, {PHI, V}, {V, V}}};
    for (const auto& [row, column] : leading) {
      CAPTURE(s.name, row, column, largest(truth, row, column), largest(error, row, column));
      REQUIRE(largest(error, row, column) < 3e-5 * largest(truth, row, column) + roundoff(row, column));
    }
    for (const auto& [row, column] : std::array<std::array<int, 2>, 4>{{{P, PHI}, {V, BG}, {P, BA}, {P, SA}}}) {
      CAPTURE(s.name, row, column, largest(truth, row, column), largest(error, row, column));
      REQUIRE(largest(error, row, column) < 0.01 * largest(truth, row, column) + roundoff(row, column));
    }
  }
}

TEST_CASE("a hundred seconds of transition matrices against the nonlinear propagation", "[strapdown][error]") {
  const double dt = 0.005;
  State x = scenarios().front().x;
  Measured measured;
  for (int i = -1; i < 20000; ++i) {
    const double t = (i + 0.5) * dt;
    const Vector3d omega{0.1 * std::sin(0.9 * t), 0.08 * std::cos(1.1 * t), 0.1 * std::sin(0.2 * t + 0.4)};
    const Vector3d f{1.5 * std::sin(0.3 * t), 1.0 * std::cos(0.4 * t), -9.8 + 0.5 * std::sin(0.7 * t)};
    measured.push_back({dt, omega * dt, f * dt});
  }
  Phi first = Phi::Identity(), second = Phi::Identity();
  State now = x;
  for (std::size_t i = 1; i < measured.size(); ++i) {
    const Measured two = {measured[i - 1], measured[i]};
    first = (modelled(now, two, Order::first) * first).eval();
    second = (modelled(now, two, Order::second) * second).eval();
    now = propagated(now, two);
  }
  const Phi truth = differences(x, measured, {50.0, 1.0, 1e-3, 1e-5, 1e-3, 1e-2, 1e-3});
  for (int row = P; row <= PHI; ++row) {
    for (int column = P; column <= SA; ++column) {
      const double error = largest(second - truth, row, column) / largest(truth, row, column);
      CAPTURE(names[static_cast<std::size_t>(row)], names[static_cast<std::size_t>(column)], error,
              largest(truth, row, column), largest(first - truth, row, column) / largest(truth, row, column));
      REQUIRE(error < 1e-4);
      REQUIRE(largest(first - truth, row, column) < 0.01 * largest(truth, row, column));
    }
  }
}

namespace {

using Nine = Eigen::Matrix<double, 9, 9>;

Nine navigation_part(const Phi& phi) { return phi.topLeftCorner<9, 9>(); }

Nine assembled(const NoiseBlocks& q) {
  Nine m;
  m << q.p_p, q.p_v, q.p_phi, q.p_v.transpose(), q.v_v, q.v_phi, q.p_phi.transpose(), q.v_phi.transpose(), q.phi_phi;
  return m;
}

/// ∫ Φ G S Gᵀ Φᵀ ds along the nonlinear step, in a thousand parts, each by the trapezoidal rule.
Nine integrated_noise(const Scenario& s, double dt, const NoiseDensity& density) {
  const int parts = 1000;
  const Increment whole = s.measured(dt).back();
  const Increment part{dt / parts, whole.dtheta / parts, whole.dv / parts};
  Navigation nav = s.x.nav;
  Nine covariance = Nine::Zero();
  for (int i = 0; i < parts; ++i) {
    const Step sub = step(nav, part, {});
    const Nine phi = navigation_part(assembled(transition(sub.mid, input_sensitivity(part), Order::second)));
    Nine q = Nine::Zero();
    q.block<3, 3>(3, 3) = sub.mid.C_nb * density.accel.asDiagonal() * sub.mid.C_nb.transpose();
    const Eigen::Matrix3d G = sub.mid.C_nb * density.gyro.asDiagonal() * sub.mid.C_nb.transpose();
    q.block<3, 3>(6, 6) = G;
    q.block<3, 3>(3, 3) += density.turned_squared * skew(sub.mid.f_n) * G * skew(sub.mid.f_n).transpose();
    covariance = (phi * (covariance + 0.5 * part.dt * q) * phi.transpose() + 0.5 * part.dt * q).eval();
    nav = sub.nav;
  }
  return covariance;
}

}  // namespace

TEST_CASE("process noise against fine integration", "[strapdown][error]") {
  const std::vector<NoiseDensity> densities = {
      {Vector3d::Constant(1e-9), Vector3d::Constant(1e-6)},
      {{1e-9, 4e-9, 2e-9}, {1e-6, 3e-6, 9e-6}},
      {{1e-6, 2e-6, 1e-6}, {1e-9, 1e-9, 3e-9}},  // gyro noise through f outweighs the accelerometers
      {Vector3d::Constant(1e-9), Vector3d::Zero()},
      {{1e-6, 2e-6, 3e-6}, Vector3d::Constant(1e-9), 0.02},
  };
  for (const Scenario& s : scenarios()) {
    for (const NoiseDensity& density : densities) {
      for (double dt : {0.01, 0.1}) {
        const Increment whole = s.measured(dt).back();
        const Nine q = assembled(process_noise(step(s.x.nav, whole, {}).mid, density));
        const Nine truth = integrated_noise(s, dt, density);
        for (int row = 0; row < 3; ++row) {
          for (int column = 0; column < 3; ++column) {
            const double size_of = truth.block<3, 3>(3 * row, 3 * column).cwiseAbs().maxCoeff();
            const double error = (q - truth).block<3, 3>(3 * row, 3 * column).cwiseAbs().maxCoeff();
            CAPTURE(s.name, dt, row, column, size_of, error);
            REQUIRE(error < 0.5 * dt * size_of + 1e-30);
          }
        }
        REQUIRE((q - q.transpose()).cwiseAbs().maxCoeff() < 1e-15 * q.cwiseAbs().maxCoeff());
        const Eigen::Matrix<double, 9, 1> scale = q.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
        const Nine scaled = scale.asDiagonal() * q * scale.asDiagonal();
        REQUIRE(Eigen::SelfAdjointEigenSolver<Nine>(scaled).eigenvalues().minCoeff() > -1e-14);
      }
    }
  }
}

}  // namespace strapdown_error_model_test
