// SPDX-License-Identifier: Apache-2.0
// The plugin's own tests: the models as battery.json composes them, against differences and the physics.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif

#include <array>
#include <cmath>

#include <binnacle/parts.hpp>

#include "common/example.hpp"
#include "ocv_curve.hpp"

using namespace binnacle;
using example::is_near;

namespace {

/// A current [A] for a time [s].
struct Load {
  double current, dt;
};

struct Moved {
  Eigen::Vector2d x;  // charge, RC voltage [V]
  Eigen::Matrix2d Phi = Eigen::Matrix2d::Identity(), Q = Eigen::Matrix2d::Zero();
};

/// One step of the process model over several samples.
Moved propagate(const ProcessModel& model, Eigen::Vector2d x, const std::vector<Load>& loads,
                bool is_linearized = true) {
  std::vector<InputSample> samples;
  Step step{0, 0, 0, {}};
  for (const Load& load : loads) {
    const Time end = step.t1 + nanoseconds(load.dt);
    samples.push_back({step.t1, end, load.dt, step.t1, end, &load.current});
    step.t1 = end, step.dt += load.dt;
  }
  step.samples = samples;

  Moved moved;
  const double* const from[] = {&x[0], &x[1]};
  double* const to[] = {&moved.x[0], &moved.x[1]};
  const auto& declared = model.declaration();
  std::vector<double*> phi, q;
  for (const Coupling& c : declared.transition) phi.push_back(&moved.Phi(c.to, c.from));
  for (const Coupling& c : declared.noise) q.push_back(&moved.Q(c.to, c.from));
  ProcessInput in;
  in.step = step;
  in.x = from;
  ProcessOutput out;
  out.x = to;
  if (is_linearized) out.phi = phi.data(), out.Qd = q.data();
  const Result result = model.propagate(in, out);
  INFO(result.reason);
  REQUIRE(result);
  moved.Q(1, 0) = moved.Q(0, 1);
  return moved;
}

struct Seen {
  Result result;
  double residual = 0, R = 0;
  std::array<double, 3> H{};  // by charge, RC voltage, error of R0
};

/// x: charge, RC voltage, and the error of R0 where that port is bound.
Seen linearize(const MeasurementModel& model, double voltage, double current, const std::array<double, 3>& x,
               bool has_r0_error = false, bool is_linearized = true) {
  Seen seen;
  const double* const values[] = {&x[0], &x[1], has_r0_error ? &x[2] : nullptr};
  std::array<MatrixView, 3> H;
  for (std::size_t i = 0; i < (has_r0_error ? 3 : 2); ++i) H[i] = {&seen.H[i], 1, 1, 1};
  std::int64_t key = 0;
  MeasurementInput in;
  in.sample.fields = &voltage;
  in.x = values;
  in.u.rates = &current;
  MeasurementOutput out;
  out.residual = {&seen.residual, 1};
  if (is_linearized) out.H = H.data();
  out.R = {&seen.R, 1, 1, 1};
  out.row_keys = {&key, 1};
  seen.result = model.linearize(in, out);
  CHECK((!seen.result || out.rows == 1));
  return seen;
}

const std::vector<Load> discharged{{3, 1}, {6, 0.5}}, charged{{-3, 1}, {-2, 2}};

}  // namespace

TEST_CASE("the open-circuit voltage goes through its points, rises, and its slope is its derivative") {
  const Eigen::VectorXd soc{{0, 0.1, 0.2, 0.5, 1}}, volts{{3, 3.4, 3.41, 3.9, 4.2}};
  const OcvCurve curve(soc, volts);
  for (int i = 0; i < 5; ++i) CHECK(is_near(curve.at(soc[i]).volts, volts[i], 1e-14));
  const double h = 1e-6;
  for (double s = -0.105; s < 1.1; s += 0.01) {
    INFO(s);
    CHECK(curve.at(s).slope > 0);
    CHECK(is_near((curve.at(s + h).volts - curve.at(s - h).volts) / (2 * h), curve.at(s).slope, 1e-6));
  }
  CHECK_THROWS_AS(OcvCurve(soc, Eigen::VectorXd(-volts)), ComponentError);
  CHECK_THROWS_AS(OcvCurve(soc, volts.head(3)), ComponentError);
}

TEST_CASE("a step is the solution of the differential equations") {
  const auto part = parts::process(*example::compose(), "cell", "cell");
  const double Q = 2.5 * 3600, R1 = 0.015, C1 = 2000, efficiency = 0.99;  // of battery.json
  for (const auto& loads : {discharged, charged}) {
    Eigen::Vector2d x(0.6, 0.02), wanted = x;
    for (const Load& load : loads)
      for (int i = 0; i < 100000; ++i) {
        const double dt = load.dt / 100000, I = load.current;
        wanted[0] -= (I < 0 ? efficiency : 1) * I * dt / Q;
        wanted[1] += (I - wanted[1] / R1) / C1 * dt;
      }
    const Moved moved = propagate(*part.model, x, loads);
    CHECK((moved.x - wanted).cwiseAbs().maxCoeff() < 1e-7);
    CHECK((moved.x[0] < x[0]) == (loads.front().current > 0));
    CHECK(propagate(*part.model, x, loads, false).x == moved.x);  // to the bit without Jacobians
  }
}

TEST_CASE("Phi is the derivative of a step") {
  const auto part = parts::process(*example::compose(), "cell", "cell");
  const Eigen::Vector2d x(0.6, 0.02);
  for (const auto& loads : {discharged, charged}) {
    const Moved moved = propagate(*part.model, x, loads);
    for (int j = 0; j < 2; ++j) {
      const Eigen::Vector2d delta = 1e-3 * Eigen::Vector2d::Unit(j);
      const Eigen::Vector2d column =
          (propagate(*part.model, x + delta, loads).x - propagate(*part.model, x - delta, loads).x) / 2e-3;
      CHECK((column - moved.Phi.col(j)).cwiseAbs().maxCoeff() < 1e-9);
    }
  }
}

// The noise of the current is a current: each short piece of it moves charge and RC voltage by as much as a step shows.
TEST_CASE("Qd is what white noise of the current does to charge and RC voltage together") {
  const auto part = parts::process(*example::compose(), "cell", "cell");
  const double q = 0.1;  // A/√Hz, of battery.json
  for (const double current : {3.0, -3.0}) {
    constexpr int pieces = 400;
    const double dt = 40.0 / pieces;  // of the order of R1 C1 = 30 s
    const std::vector<Load> loads(pieces, {current, dt});
    Eigen::Matrix2d wanted = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < pieces; ++i) {
      auto more = loads, less = loads;
      more[i].current += 0.5, less[i].current -= 0.5;
      const Eigen::Vector2d g = propagate(*part.model, {0.6, 0}, more).x - propagate(*part.model, {0.6, 0}, less).x;
      wanted += q * q / dt * g * g.transpose();  // the mean of white noise over dt has the variance q²/dt
    }
    const Eigen::Matrix2d Q = propagate(*part.model, {0.6, 0}, loads).Q;
    INFO("wanted\n" << wanted << "\nis\n" << Q);
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) CHECK(is_near(Q(i, j), wanted(i, j), 1e-4));
  }
}

TEST_CASE("H is the derivative of what the terminals show") {
  const auto composition =
      example::compose({R"(/filters/cell/blocks/aging={"type": "vector", "size": 1, "unit": "V/A", "sigma": "5 mV/A"})",
                        R"(/filters/cell/process/aging={"type": "random_constant", "blocks": {"x": "aging"}})",
                        R"(/filters/cell/measurements/voltage/blocks/r0_error="aging")"});
  const auto part = parts::measurement(*composition, "cell", "voltage");
  for (const double current : {4.0, -2.0})
    for (const double soc : {0.03, 0.45, 0.83}) {
      const std::array<double, 3> x{soc, 0.03, 0.002};
      const Seen seen = linearize(*part.model, 3.7, current, x, true);
      REQUIRE(seen.result);
      CHECK(is_near(seen.R, 0.005 * 0.005 + 0.02 * 0.02 * 0.1 * 0.1, 1e-9));
      CHECK(seen.H[0] > 0);  // a fuller cell shows more
      for (std::size_t j = 0; j < 3; ++j) {
        auto up = x, down = x;
        up[j] += 1e-6, down[j] -= 1e-6;
        const double slope = -(linearize(*part.model, 3.7, current, up, true).residual -
                               linearize(*part.model, 3.7, current, down, true).residual) /
                             2e-6;
        CHECK(is_near(seen.H[j], slope, 1e-6));
      }
      CHECK(linearize(*part.model, 3.7, current, x, true, false).residual == seen.residual);
    }
}

TEST_CASE("the voltage under load is Kirchhoff's") {
  const auto part = parts::measurement(*example::compose(), "cell", "voltage");
  // At 60 % the curve of battery.json shows 3.8 V: 3.8 − 0.03 − 0.02 · 5.
  CHECK(std::abs(linearize(*part.model, 3.67, 5, {0.6, 0.03, 0}).residual) < 1e-12);
  CHECK(is_near(linearize(*part.model, 3.70, 5, {0.6, 0.03, 0}).residual, 0.03, 1e-9));
  const double nothing = std::nan("");
  CHECK_FALSE(linearize(*part.model, nothing, 5, {0.6, 0.03, 0}).result);
}

TEST_CASE("errors of fifty runs are as large as the filter believes") {
  const auto figures = example::study();
  for (const auto& [metric, dof] : std::map<std::string, double>{{"cell/soc/nees", 1}, {"cell/rc/nees", 1}}) {
    const auto& figure = figures.at(metric);
    INFO(metric << " " << figure.mean << " in " << figure.runs << " runs");
    CHECK(figure.runs == 50);
    CHECK(std::abs(figure.mean - dof) < 2.58 * std::sqrt(2 * dof / figure.runs));  // 99 %
  }
  CHECK(std::abs(figures.at("cell/voltage/nis").mean - 1) < 2.58 * std::sqrt(2.0 / (50 * 3600)));
  CHECK(figures.at("cell/soc.charge/rms").mean < 1.0);  // %, of 10 % at the start
}
